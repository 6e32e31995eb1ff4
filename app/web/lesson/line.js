// @ts-check
// Numbers along a line: other runs as dots, one upon another where they are alike, this run among
// them, and what was expected above.

import { element } from "../time/dom.js";
import { svgElement } from "./compass.js";
import { MANY, SHAPES, nameOf, row } from "./marks.js";
import { numeral, word } from "./words.js";

const WIDE = 300;
const EDGE = 14;
const DOT = 9;
const MARK = 16;
const AXIS_PX = 20;
const MOST_HIGH = 8;

/** A distance of ticks that one reads easily. @param {number} span */
const tickSize = (span) => {
  const power = 10 ** Math.floor(Math.log10(span / 4));
  return [1, 2, 5, 10].map((by) => by * power).find((size) => span / size <= 4) ?? span;
};

/** @param {number[]} values */
const ends = (values) => {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const room = Math.max((high - low) * 0.06, Math.abs(high) * 0.01, 0.5);
  return [low < 0 ? low - room : Math.max(low - room, 0), high + room];
};

/** @param {import("./state.js").Many} many */
const spread = ({ values }) => {
  const [low, high] = [Math.min(...values), Math.max(...values)];
  return low === high ? numeral(low, 1) : word("range", numeral(low, 1), numeral(high, 1));
};

/** @type {import("./reveal.js").Picture} */
export const line = (reveal, { unit }) => {
  const { guess, saw, run } = reveal;
  const node = element("div", "line");
  const isNumber = (/** @type {unknown} */ value) => typeof value === "number";
  const groups = MANY.map((whose) => /** @type {const} */ ([whose, reveal[whose]?.values ?? []]));
  const all = [guess, run, ...groups.flatMap(([, values]) => values)].filter(isNumber);
  const [low, high] = ends(all);
  const x = (/** @type {number} */ value) => EDGE + ((WIDE - 2 * EDGE) * (value - low)) / (high - low);

  // Dots that would lie on each other stand on each other.
  /** @type {Array<{x: number, level: number, whose: import("./marks.js").Whose}>} */
  const dots = [];
  let floor = 0;
  for (const [whose, values] of groups) {
    /** @type {Map<number, number>} */
    const piles = new Map();
    for (const value of [...values].sort((one, other) => one - other)) {
      const pile = Math.round(x(value) / DOT);
      const level = piles.get(pile) ?? 0;
      piles.set(pile, level + 1);
      dots.push({ x: pile * DOT, level: floor + level, whose });
    }
    floor += Math.max(0, ...piles.values());
  }
  const rise = DOT * Math.min(1, MOST_HIGH / Math.max(floor, 1));
  const ground = MARK + 6 + Math.max(floor * rise, MARK) + 4;
  const svg = svgElement("svg", { viewBox: `0 0 ${WIDE} ${ground + AXIS_PX}`, "aria-hidden": "true" });
  svg.append(svgElement("path", { d: `M0 ${ground}H${WIDE}`, class: "axis" }));
  const size = tickSize(high - low);
  for (let tick = Math.ceil(low / size) * size; tick <= high; tick += size) {
    const text = svgElement("text", { x: x(tick), y: ground + 15 });
    text.textContent = numeral(tick, size < 1 ? 2 : 0);
    svg.append(svgElement("path", { d: `M${x(tick)} ${ground}v4`, class: "axis" }), text);
  }
  for (const { x: at, level, whose } of dots)
    svg.append(
      svgElement("circle", { cx: at, cy: ground - rise * (level + 0.5) - 1, r: DOT / 2 - 0.8, class: `of-${whose}` }),
    );
  for (const [whose, value] of /** @type {const} */ ([["guess", guess], ["run", run]])) {
    if (!isNumber(value)) continue;
    const top = whose === "guess" ? 2 : ground - MARK - 1;
    const [left, mid] = [x(value) - MARK / 2, x(value)];
    svg.append(svgElement("path", { d: `M${mid} ${whose === "guess" ? top + MARK : top + MARK}V${ground}`, class: `stem of-${whose}` }));
    svg.append(svgElement("path", { d: SHAPES[whose], class: `of-${whose}`, transform: `translate(${left} ${top})` }));
  }
  const list = document.createElement("dl");
  // Lessons have the word in the plural.
  const withUnit = (/** @type {string} */ text) =>
    !unit || (text === "1" && /^\p{L}+$/u.test(unit)) ? text : `${text} ${unit}`;
  if (isNumber(guess)) list.append(row("guess", nameOf("guess"), withUnit(numeral(guess, 1))));
  if (isNumber(saw)) list.append(row("saw", nameOf("saw"), withUnit(numeral(saw, 1))));
  if (isNumber(run)) list.append(row("run", nameOf("run"), withUnit(numeral(run, 1))));
  for (const whose of MANY) {
    const many = reveal[whose];
    if (many?.values.length) list.append(row(whose, nameOf(whose, many), withUnit(spread(many))));
  }
  node.append(svg, list);
  return node;
};
