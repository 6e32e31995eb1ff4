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
/** What stands after a name. */
const AFTER_PX = 36;

/** The line that was looked at when this was drawn last, and how many there were. */
let last = NaN;
let drawn = 0;

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
    // Strokes that come down to other lines cross this row, or end in it.
    const strokes = lines.slice(index + 1).map(({ fork: begun }) => shareOf(bar.axis, begun));
    const free = Math.max(0, ...strokes.filter((stroke) => stroke < from));
    const came = /** @type {HTMLElement} */ (plot.children[2]);
    const side = tell(came, line, { from, until, free }, wide / size);
    // A name reaches as far as there is nothing else.
    const room = side === "before" ? 0 : Math.min(from, ...strokes) * wide - AFTER_PX;
    const name = /** @type {HTMLElement} */ (gutter.children[0]);
    name.style.maxWidth = `calc(100% + ${Math.max(Math.round(room), 0)}px)`;
  });
  sort(parent);
  parent.style.setProperty("--scroll-bar", `${parent.offsetWidth - parent.clientWidth}px`);
  if (lines.length !== drawn) last = NaN;
  drawn = lines.length;
};

/**
 * Have the keyboard go by the order that one sees, unless it is there and would lose its place.
 * @param {HTMLElement} parent
 */
const sort = (parent) => {
  const rows = /** @type {HTMLElement[]} */ ([...parent.children]);
  const sorted = rows.toSorted((one, other) => Number(one.style.order) - Number(other.style.order));
  const isSorted = rows.every((row, index) => row === sorted[index]);
  if (!isSorted && !parent.contains(document.activeElement)) parent.append(...sorted);
};

const makeLine = () => {
  const row = element("div", "row line");
  row.tabIndex = 0;
  row.setAttribute("role", "button");
  const gutter = element("div", "gutter");
  // A button for those who have but one, and those who do not look for a menu (menu.js).
  const more = element("button", "more", "\u22ef");
  more.tabIndex = -1;
  more.title = "What can be done with it";
  more.setAttribute("aria-label", more.title);
  more.setAttribute("aria-haspopup", "menu");
  gutter.append(element("span", "name"), element("b", "tag", "live"), more);
  const plot = element("div", "plot");
  plot.append(element("i", "fork"), element("i", "stroke"), element("span", "came"));
  row.append(gutter, plot);
  return row;
};

/**
 * Where a line is, and up to where there is nothing before it, as shares of the axis.
 * @typedef {{from: number, until: number, free: number}} Reach
 */

/**
 * Say what a line came to, and where that stands.
 * @param {HTMLElement} came
 * @param {Line} line
 * @param {Reach} place
 * @param {number} wide the axis, in sizes of the type
 */
const tell = (came, { reward, digest, growing, until: end }, place, wide) => {
  const more = growing ? `at ${grouped(end.trial)} …` : digest;
  const texts = more ? [`${reward} \u00b7 ${more}`, reward] : [reward];
  const [text, side] = spot(texts, place, wide);
  write(came, text);
  came.className = `came ${side}`;
  const { from, until } = place;
  came.style.left = side === "before" ? "" : percent(side === "on" ? (from + until) / 2 : until);
  came.style.right = side === "before" ? percent(1 - from) : "";
  return side;
};

/**
 * The longest of some texts that has room after a line, on it or before it, and where; else the
 * shortest, on it.
 * @param {string[]} texts the longest first
 * @param {Reach} place
 * @param {number} wide
 * @returns {[string, "after" | "before" | "on"]}
 */
const spot = (texts, { from, until, free }, wide) => {
  for (const text of texts) {
    const needs = (CHARACTER * (text.length + 2)) / (wide || 1);
    if (until + needs <= 1) return [text, "after"];
    // So that one sees that there is a line.
    if (until - from >= 2 * needs) return [text, "on"];
    if (from - free >= needs) return [text, "before"];
  }
  return [texts[texts.length - 1], "on"];
};

/**
 * @param {HTMLElement} parent
 * @param {number} seen the line that is looked at
 */
export const markTree = (parent, seen) => {
  for (const row of /** @type {Iterable<HTMLElement>} */ (parent.children)) {
    const isSeen = row.dataset.line === `${seen}`;
    row.classList.toggle("seen", isSeen);
    attribute(row, "aria-current", isSeen ? "true" : null);
    if (isSeen && seen !== last) show(parent, row);
  }
  last = seen;
};

/**
 * Scroll to a row, and nothing around the tree.
 * @param {HTMLElement} parent
 * @param {HTMLElement} row
 */
const show = (parent, row) => {
  const above = row.offsetTop - parent.offsetTop;
  const below = above + row.offsetHeight - parent.clientHeight;
  if (above < parent.scrollTop) parent.scrollTop = above;
  else if (below > parent.scrollTop) parent.scrollTop = below;
};
