// @ts-check
// A curve that was drawn, the one that came, and the band of other runs.

import { element } from "../time/dom.js";
import { svgElement } from "./compass.js";
import { nameOf, row as rowOf } from "./marks.js";
import { numeral, word } from "./words.js";

const WIDE = 320;
const HIGH = 170;
const LEFT = 30;
const BELOW = 20;
const HANDLE = 3.5;

/** @typedef {Array<[number, number]>} Points */

/**
 * A row of what is said, with a piece of the line that it is about.
 * @param {import("./marks.js").Whose} whose
 * @param {string} name
 * @param {string} value
 */
const row = (whose, name, value) => {
  const made = rowOf(whose, name, value);
  const piece = svgElement("svg", { viewBox: "0 0 24 12", class: "swatch piece", "aria-hidden": "true" });
  piece.append(
    whose === "twenty"
      ? svgElement("path", { d: "M0 1H24V11H0Z", class: "area" })
      : svgElement("path", { d: "M0 6H24", class: `curve of-${whose}` }),
  );
  if (whose === "guess") piece.append(svgElement("circle", { cx: 12, cy: 6, r: HANDLE, class: "handle" }));
  made.querySelector(".swatch")?.replaceWith(piece);
  return made;
};

/** @type {import("./reveal.js").Picture} */
export const curves = ({ guess, run, twenty }) => {
  const node = element("div", "curves");
  /** @type {Points} */
  const drawn = guess ?? [];
  /** @type {Points} */
  const came = run ?? [];
  const trials = [...drawn, ...came].map(([trial]) => trial).concat(twenty?.at ?? []);
  const rewards = [...drawn, ...came].map(([, reward]) => reward).concat(twenty?.low ?? [], twenty?.high ?? []);
  const [first, last] = [Math.min(...trials), Math.max(...trials)];
  const [low, high] = [Math.min(0, ...rewards) - 3, Math.max(0, ...rewards) + 3];
  const x = (/** @type {number} */ trial) => LEFT + ((WIDE - LEFT - 6) * (trial - first)) / Math.max(last - first, 1);
  const y = (/** @type {number} */ reward) => 4 + ((HIGH - BELOW - 4) * (high - reward)) / (high - low);
  const path = (/** @type {Points} */ points) =>
    points.map(([trial, reward], at) => `${at ? "L" : "M"}${x(trial).toFixed(1)} ${y(reward).toFixed(1)}`).join("");

  const svg = svgElement("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, "aria-hidden": "true" });
  for (const reward of [-50, 0, 50, 100].filter((level) => level > low && level < high)) {
    const text = svgElement("text", { x: LEFT - 4, y: y(reward) + 4, class: "of-axis" });
    text.textContent = numeral(reward);
    svg.append(svgElement("path", { d: `M${LEFT} ${y(reward)}H${WIDE}`, class: reward ? "level" : "axis" }), text);
  }
  for (const [trial, anchor] of /** @type {const} */ ([[first, "start"], [last, "end"]])) {
    const text = svgElement("text", { x: x(trial), y: HIGH - 4, class: anchor });
    text.textContent = numeral(trial);
    svg.append(text);
  }
  if (twenty?.at?.length) {
    /** @type {(values: number[]) => Points} */
    const along = (values) => twenty.at.map((/** @type {number} */ trial, /** @type {number} */ at) => [trial, values[at]]);
    const back = along(twenty.low).reverse();
    svg.append(svgElement("path", { d: `${path(along(twenty.high))}${path(back).replace("M", "L")}Z`, class: "area" }));
    if (twenty.middle?.length) svg.append(svgElement("path", { d: path(along(twenty.middle)), class: "curve of-twenty" }));
  }
  if (came.length) svg.append(svgElement("path", { d: path(came), class: "curve of-run" }));
  if (drawn.length) {
    svg.append(svgElement("path", { d: path(drawn), class: "curve of-guess" }));
    for (const [trial, reward] of drawn)
      svg.append(svgElement("circle", { cx: x(trial), cy: y(reward), r: HANDLE, class: "handle" }));
  }
  const list = document.createElement("dl");
  // At the trials of the handles, so that one reads what one sees.
  const nearest = (/** @type {number} */ trial) =>
    came.reduce((best, point) => (Math.abs(point[0] - trial) < Math.abs(best[0] - trial) ? point : best));
  const read = (/** @type {Points} */ points) => points.map(([, reward]) => numeral(reward)).join(", ");
  const places = drawn.length ? drawn : came;
  if (drawn.length) list.append(row("guess", nameOf("guess"), read(drawn)));
  if (came.length) list.append(row("run", nameOf("run"), read(places.map(([trial]) => nearest(trial)))));
  if (twenty) {
    const [least, most] = [Math.min(...twenty.low), Math.max(...twenty.high)];
    list.append(row("twenty", nameOf("twenty", twenty), word("range", numeral(least), numeral(most))));
  }
  node.append(svg, list);
  return node;
};
