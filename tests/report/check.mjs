// node check.mjs CHROMIUM FILE...: opens each page that `billow compare --report` wrote. Exit code 1
// unless all work: no word of an error, no request, every picture decodes, sliders move, planes are
// outlined when they are pointed at.
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const [executablePath, ...files] = process.argv.slice(2);
const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
let faults = files.length === 0 ? 1 : 0;

async function check(file, colorScheme) {
  const page = await browser.newPage({ colorScheme, viewport: { width: 1200, height: 900 } });
  page.setDefaultTimeout(5000);
  page.setDefaultNavigationTimeout(60000);
  const complain = (text) => {
    console.log(`${file}, ${colorScheme}: ${text}`);
    ++faults;
  };
  const url = pathToFileURL(resolve(file)).href;
  page.on("console", (said) => {
    if (["error", "warning"].includes(said.type())) complain(said.text());
  });
  page.on("pageerror", (why) => complain(why.message));
  page.on("dialog", (box) => {
    complain(`a dialog: ${box.message()}`);
    box.dismiss();
  });
  page.on("request", (request) => {
    if (request.url() !== url && !request.url().startsWith("data:")) {
      complain(`asks for ${request.url()}`);
    }
  });
  await page.goto(url);

  const pictures = await page.$$eval("img", async (all) => {
    await Promise.all(all.map((img) => img.decode().catch(() => {})));
    return all.map((img) => ({ alt: img.alt, width: img.naturalWidth }));
  });
  if (pictures.length < 4) complain(`has ${pictures.length} pictures`);
  for (const { alt, width } of pictures) {
    if (!(width > 0)) complain(`the picture '${alt}' does not decode`);
  }
  const rows = await page.locator("#errors tbody tr").count();
  if (rows < 11) complain(`the table of errors has ${rows} rows`);
  if ((await page.locator("svg.plot").count()) < 8) complain("plots are missing");

  // By the range below, and by the pointer in the picture.
  const slider = page.locator(".slider").first();
  const clip = () =>
    slider.locator("img.after").first().evaluate((img) => getComputedStyle(img).clipPath);
  const seen = [await clip()];
  await slider.locator("xpath=following-sibling::input").fill("20");
  seen.push(await clip());
  await slider.scrollIntoViewIfNeeded();
  const box = await slider.boundingBox();
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 0.5 * box.height);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.8 * box.width, box.y + 0.5 * box.height);
  await page.mouse.up();
  seen.push(await clip());
  if (new Set(seen).size !== 3) complain(`the slider does not move: ${seen.join(", ")}`);

  const clouds = await page.locator("#cloud option").count();
  for (let i = 0; i < clouds; ++i) {
    await page.selectOption("#cloud", String(i));
    const shown = await page.$$eval("[data-cloud]", (all) =>
      [...new Set(all.filter((part) => !part.hidden).map((part) => part.dataset.cloud))]);
    if (shown.join() !== String(i)) complain(`cloud ${i} is chosen, ${shown.join()} is shown`);
  }

  const planes = page.locator(".atlas .plane");
  if ((await planes.count()) > 0) {
    const plane = planes.first();
    const stroke = () =>
      plane.locator(".edge").evaluate((edge) => getComputedStyle(edge).stroke);
    await page.mouse.move(0, 0);
    const before = await stroke();
    // Into the middle of its first triangle.
    await plane.scrollIntoViewIfNeeded();
    const at = await plane.locator(".area").evaluate((area) => {
      const points = [0, 1, 2].map((i) => area.getAttribute("d").split(/[MLZ]/)[i + 1]
        .split(" ").map(Number));
      const middle = new DOMPoint((points[0][0] + points[1][0] + points[2][0]) / 3,
        (points[0][1] + points[1][1] + points[2][1]) / 3);
      const { x, y } = middle.matrixTransform(area.getScreenCTM());
      return { x, y };
    });
    await page.mouse.move(at.x, at.y);
    const after = await stroke();
    if (before === after) complain(`pointing at a plane changes nothing: ${before}`);
    const said = await page.locator(".said").first().textContent();
    if (!/^plane \d+: \d+ × \d+ texels/.test(said)) complain(`of a plane it says '${said}'`);
  } else if (!file.includes("no_planes")) {
    complain("no plane is drawn over the atlas");
  }
  await page.close();
}

for (const file of files) {
  for (const scheme of ["light", "dark"]) {
    await check(file, scheme).catch((why) => {
      console.log(`${file}: ${why.message ?? why}`);
      ++faults;
    });
  }
  console.log(`${file} was opened`);
}
await browser.close();
process.exit(faults === 0 ? 0 : 1);
