// What every page of html_report looks like and does.
#pragma once

namespace cli {

inline constexpr const char* page_style = R"css(
:root { color-scheme: light dark;
  --page: #fbfbfa; --ink: #1c1e21; --faint: #666b72; --line: #dcdedf; --card: #f1f2f2;
  --mark: #0b63b0; --s0: #0b63b0; --s1: #c2540a; --s2: #18794e; --s3: #9a2a80; --s4: #8a6d00;
  --s5: #54606e; }
@media (prefers-color-scheme: dark) { :root {
  --page: #17181a; --ink: #e6e7e9; --faint: #9aa0a8; --line: #34373b; --card: #202225;
  --mark: #6fb3f2; --s0: #6fb3f2; --s1: #f29a5c; --s2: #5cc592; --s3: #e08acb; --s4: #d8bd52;
  --s5: #a9b4c0; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem; max-width: 78rem; background: var(--page);
  color: var(--ink); font: 15px/1.5 system-ui, sans-serif; }
h1 { font-size: 1.5rem; font-weight: 600; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; font-weight: 600; margin: 2.2rem 0 .6rem;
  border-bottom: 1px solid var(--line); padding-bottom: .3rem; }
h3 { font-size: 1rem; font-weight: 600; margin: 1.4rem 0 .4rem; }
p, figcaption { color: var(--faint); max-width: 62rem; margin: .3rem 0; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .7rem; border-bottom: 1px solid var(--line); text-align: right;
  white-space: nowrap; }
th { font-weight: 600; }
th[scope=row], td.text { text-align: left; }
thead th.group { text-align: center; overflow-wrap: anywhere; white-space: normal; }
td.best { font-weight: 700; }
td small { color: var(--faint); }
.row { display: flex; flex-wrap: wrap; gap: 1rem; align-items: flex-start; }
figure { margin: .5rem 0; }
figcaption { font-size: .85rem; }
.slider { position: relative; width: 24rem; max-width: 90vw; aspect-ratio: 1; --at: 50%;
  background: var(--card); touch-action: pan-y; cursor: ew-resize; }
.slider img { position: absolute; inset: 0; width: 100%; height: 100%; }
.slider .after { clip-path: inset(0 0 0 var(--at)); }
.slider::after { content: ""; position: absolute; top: 0; bottom: 0; left: var(--at); width: 1px;
  background: #000; box-shadow: 0 0 0 1px #fff8; pointer-events: none; }
.slider + input { width: 24rem; max-width: 90vw; margin: .3rem 0; accent-color: var(--mark); }
.difference { width: 17rem; max-width: 90vw; }
.difference img { width: 100%; aspect-ratio: 1; display: block; }
.atlas { position: relative; max-width: 46rem;
  background: repeating-conic-gradient(#bbb 0 25%, #ddd 0 50%) 0 0 / 16px 16px; }
.atlas img, .atlas svg { display: block; width: 100%; }
.atlas svg { position: absolute; inset: 0; height: 100%; }
.plane { cursor: crosshair; }
.plane .area { fill: transparent; }
.plane .edge { fill: none; stroke: transparent; stroke-width: 2; vector-effect: non-scaling-stroke; }
.outlined .edge { stroke: #0008; stroke-width: 1; }
.plane:hover .edge, .plane:focus .edge { stroke: #e02020; stroke-width: 3; }
.plane:hover .area, .plane:focus .area { fill: #e0202033; }
.plane:focus { outline: none; }
.said { min-height: 1.5em; color: var(--ink); }
.heat { display: inline-block; width: 9rem; height: .7rem; vertical-align: middle;
  background: linear-gradient(90deg, #0d0d40, #66146b, #cc3d47, #f79429, #fcf5a3); }
.scale { white-space: nowrap; }
.swatch { display: inline-block; width: .8rem; height: .8rem; vertical-align: middle;
  margin-right: .2rem; }
svg.plot { width: 30rem; max-width: 92vw; background: var(--card); }
svg.plot text { fill: var(--faint); font: 11px system-ui, sans-serif; }
svg.plot .axis { stroke: var(--line); fill: none; }
svg.plot .curve { fill: none; stroke-width: 1.6; }
.s0 { stroke: var(--s0); } .s1 { stroke: var(--s1); } .s2 { stroke: var(--s2); }
.s3 { stroke: var(--s3); } .s4 { stroke: var(--s4); } .s5 { stroke: var(--s5); }
.d0 { fill: var(--s0); } .d1 { fill: var(--s1); } .d2 { fill: var(--s2); }
.d3 { fill: var(--s3); } .d4 { fill: var(--s4); } .d5 { fill: var(--s5); }
.b0 { background: var(--s0); } .b1 { background: var(--s1); } .b2 { background: var(--s2); }
.b3 { background: var(--s3); } .b4 { background: var(--s4); } .b5 { background: var(--s5); }
select { font: inherit; max-width: 100%; }
[hidden] { display: none !important; }
)css";

inline constexpr const char* page_script = R"js(
"use strict";
for (const slider of document.querySelectorAll(".slider")) {
  const range = slider.nextElementSibling;
  const show = (at) => slider.style.setProperty("--at", at + "%");
  range.addEventListener("input", () => show(range.value));
  const drag = (event) => {
    if (event.buttons === 0) return;
    const box = slider.getBoundingClientRect();
    const at = 100 * Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
    range.value = at;
    show(at);
  };
  slider.addEventListener("pointerdown", drag);
  slider.addEventListener("pointermove", drag);
  for (const picture of slider.querySelectorAll("img")) picture.draggable = false;
}
const chosen = document.getElementById("cloud");
if (chosen) {
  const show = () => {
    for (const part of document.querySelectorAll("[data-cloud]")) {
      part.hidden = part.dataset.cloud !== chosen.value;
    }
  };
  chosen.addEventListener("change", show);
  show();
}
for (const atlas of document.querySelectorAll(".atlas")) {
  const said = atlas.nextElementSibling;
  for (const plane of atlas.querySelectorAll(".plane")) {
    const tell = () => { said.textContent = plane.dataset.said; };
    plane.addEventListener("pointerenter", tell);
    plane.addEventListener("focus", tell);
  }
}
for (const box of document.querySelectorAll(".outlines")) {
  const drawing = document.getElementById(box.dataset.of);
  box.addEventListener("change", () => drawing.classList.toggle("outlined", box.checked));
}
)js";

}  // namespace cli
