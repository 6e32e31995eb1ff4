// @ts-check
// The lines of a session above the lanes, each from where it branched off.

import { shareOf } from "./axis.js";
import { attribute, element, grouped, keep, percent, reach, write } from "./dom.js";

/**
 * @typedef {import("./state.js").Bar} Bar
 * @typedef {import("./state.js").Line} Line
 */

const MOST_ROWS = 9;
/** Width of a character of what is written beside a line, on the safe side, as a share of its type. */
const CHARACTER = 0.62;
const APART_PX = 8;

/**
 * @param {HTMLElement} parent
 * @param {Bar} bar
 * @param {number} wide width of the axis in pixels
 */
export const drawTree = (parent, bar, wide) => {
  const lines = bar.lines.slice(0, MOST_ROWS);
  parent.hidden = lines.length === 0;
  const size = parseFloat(getComputedStyle(parent).fontSize);
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
    reach(stroke, from, until);
    const above = lines.findIndex(({ line: number }) => number === line.parent);
    const fork = /** @type {HTMLElement} */ (plot.children[0]);
    fork.hidden = above < 0;
    fork.style.left = percent(from);
    fork.style.setProperty("--rows", `${index - above}`);
    // A name reaches as far as no stroke comes down or begins.
    const starts = lines.slice(index).map(({ fork: begun }) => shareOf(bar.axis, begun));
    const free = Math.max(Math.min(...starts) * wide - APART_PX, 0);
    const name = /** @type {HTMLElement} */ (gutter.children[0]);
    name.style.maxWidth = `calc(100% + ${Math.round(free)}px)`;
    tell(/** @type {HTMLElement} */ (plot.children[2]), line, from, until, wide / size);
  });
};

const makeLine = () => {
  const row = element("div", "row line");
  row.tabIndex = 0;
  row.setAttribute("role", "button");
  const gutter = element("div", "gutter");
  gutter.append(element("span", "name"), element("b", "tag", "live"));
  const plot = element("div", "plot");
  plot.append(element("i", "fork"), element("i", "stroke"), element("span", "came"));
  row.append(gutter, plot);
  return row;
};

/**
 * What it came to: after the line, before it, or on it, where there is room.
 * @param {HTMLElement} came
 * @param {Line} line
 * @param {number} from
 * @param {number} until
 * @param {number} wide the axis, in sizes of the type
 */
const tell = (came, { reward, digest, growing, until: end }, from, until, wide) => {
  const more = growing ? `at ${grouped(end.trial)} …` : digest;
  const texts = more ? [`${reward} \u00b7 ${more}`, reward] : [reward];
  const [text, side] = spot(texts, from, until, wide);
  write(came, text);
  came.className = `came ${side}`;
  const { style } = came;
  style.left = side === "before" ? "" : percent(side === "on" ? (from + until) / 2 : until);
  style.right = side === "before" ? percent(1 - from) : "";
};

/**
 * The longest of some texts that has room after a line or before it, and where; else the shortest, on it.
 * @param {string[]} texts the longest first
 * @param {number} from
 * @param {number} until
 * @param {number} wide
 * @returns {[string, "after" | "before" | "on"]}
 */
export const spot = (texts, from, until, wide) => {
  for (const text of texts) {
    const needs = (CHARACTER * (text.length + 2)) / (wide || 1);
    if (until + needs <= 1) return [text, "after"];
    if (from >= needs) return [text, "before"];
    if (until - from >= 2 * needs) return [text, "on"];
  }
  return [texts[texts.length - 1], "on"];
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
