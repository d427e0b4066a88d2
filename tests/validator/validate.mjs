// node validate.mjs FILE...: the Khronos validator's word on each file. Exit code 1 unless all have
// zero errors and zero warnings.
import { readFile } from "node:fs/promises";
import { dirname, resolve } from "node:path";
import validator from "gltf-validator";

const files = process.argv.slice(2);
let faults = files.length === 0 ? 1 : 0;
for (const file of files) {
  try {
    const report = await validator.validateBytes(new Uint8Array(await readFile(file)), {
      uri: file,
      externalResourceFunction: (uri) =>
        readFile(resolve(dirname(file), decodeURIComponent(uri))).then((b) => new Uint8Array(b)),
    });
    const { numErrors, numWarnings, messages } = report.issues;
    console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings`);
    for (const { severity, code, pointer, offset, message } of messages) {
      const word = ["error", "warning", "info", "hint"][severity];
      console.log(`  ${word} ${code} at ${pointer ?? offset ?? "start"}: ${message}`);
    }
    faults += numErrors + numWarnings;
  } catch (why) {
    console.log(`${file}: ${why.message ?? why}`);
    ++faults;
  }
}
process.exit(faults === 0 ? 0 : 1);
