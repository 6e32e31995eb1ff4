// @ts-check
// The lines of a session above the lanes, each from where it branched off.

import { shareOf } from "./axis.js";
import { attribute, element, grouped, keep, percent, span, write } from "./dom.js";

/**
 * @typedef {import("./state.js").Bar} Bar
 * @typedef {import("./state.js").Line} Line
 */

const MOST_ROWS = 9;
/** Width of a character of what is written beside a line, on the safe side. */
const CHARACTER_PX = 7.2;

/**
 * @param {HTMLElement} parent
 * @param {Bar} bar
 * @param {number} wide width of the axis in pixels
 */
export const drawTree = (parent, bar, wide) => {
  const lines = bar.lines.slice(0, MOST_ROWS);
  parent.hidden = lines.length === 0;
  keep(parent, lines, ({ line }) => `${line}`, makeLine, (row, line, index) => {
    row.style.order = `${index}`;
    row.dataset.line = `${line.line}`;
    row.classList.toggle("live", line.live);
    row.classList.toggle("growing", line.growing);
    attribute(row, "title", line.hint);
    attribute(row, "aria-label", line.hint);
    const [gutter, plot] = row.children;
    write(gutter.children[0], line.name);
    const stroke = /** @type {HTMLElement} */ (plot.children[1]);
    const from = shareOf(bar.axis, line.fork);
    const until = Math.max(shareOf(bar.axis, line.until), from);
    span(stroke, from, until);
    const above = lines.findIndex(({ line: number }) => number === line.parent);
    const fork = /** @type {HTMLElement} */ (plot.children[0]);
    fork.hidden = above < 0;
    fork.style.left = percent(from);
    fork.style.setProperty("--rows", `${index - above}`);
    tell(/** @type {HTMLElement} */ (plot.children[2]), line, from, until, wide);
  });
};

const makeLine = () => {
  const row = element("div", "row line");
  row.tabIndex = 0;
  row.setAttribute("role", "button");
  const gutter = element("div", "gutter");
  gutter.append(element("span", "name"), element("b", "tag", "live"));
  const plot = element("div", "plot");
  plot.append(element("i", "fork"), element("i", "stroke"), element("span", "told"));
  row.append(gutter, plot);
  return row;
};

/**
 * What it came to: after the line, before it, or on it, where there is room.
 * @param {HTMLElement} told
 * @param {Line} line
 * @param {number} from
 * @param {number} until
 * @param {number} wide
 */
const tell = (told, { reward, digest, growing, until: end }, from, until, wide) => {
  const last = growing ? `at ${grouped(end.trial)} …` : digest;
  const text = `${reward}${last ? ` \u00b7 ${last}` : ""}`;
  write(told, text);
  const needs = (CHARACTER_PX * (text.length + 2)) / (wide || 1);
  const side = until + needs <= 1 ? "after" : from >= needs ? "before" : "on";
  told.className = `told ${side}`;
  const { style } = told;
  style.left = side === "before" ? "" : percent(side === "on" ? (from + until) / 2 : until);
  style.right = side === "before" ? percent(1 - from) : "";
};

/**
 * @param {HTMLElement} parent
 * @param {number} seen the line that is looked at
 */
export const markTree = (parent, seen) => {
  for (const row of parent.children) {
    const isSeen = /** @type {HTMLElement} */ (row).dataset.line === `${seen}`;
    row.classList.toggle("seen", isSeen);
    attribute(row, "aria-current", isSeen ? "true" : null);
  }
};
