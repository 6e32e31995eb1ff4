// @ts-check
// The learning curves, one picture that is as wide and high as there is room.

import { percent } from "./dom.js";

/**
 * @typedef {import("./state.js").Bar} Bar
 * @typedef {import("./state.js").Points} Points
 */

/** Units of the picture from left to right, and from bottom to top. */
const WIDE = 1000;
const HIGH = 100;
/** Room beyond the ends of the axis of rewards, as a share of it, so that no number is cut. */
const MARGIN = 0.06;
const SVG = "http://www.w3.org/2000/svg";

/**
 * From a reward to its height, as a share.
 * @param {[number, number]} rewards
 */
export const heightOf = ([low, high]) => {
  const margin = MARGIN * (high - low);
  const whole = high - low + 2 * margin;
  return (/** @type {number} */ reward) =>
    Math.min(Math.max((reward - low + margin) / whole, 0), 1);
};

/**
 * The paths of a picture, by what they are.
 * @param {Bar} bar
 * @returns {Array<[string, string]>}
 */
const pathsOf = ({ rewards, levels, learned, greedy, gaps, ghost }) => {
  const up = heightOf(rewards);
  const y = (/** @type {number} */ reward) => (HIGH * (1 - up(reward))).toFixed(1);
  const places = (/** @type {Points} */ { at, reward }) => at.map((x, i) => `${(WIDE * x).toFixed(1)} ${y(reward[i])}`);
  const line = (/** @type {Points | null} */ points) => (points?.at.length ? `M${places(points).join("L")}` : "");
  const dots = places(greedy);
  const between = (/** @type {boolean} */ isGap) =>
    dots
      .slice(1)
      .map((dot, i) => (gaps[i] === isGap ? `M${dots[i]}L${dot}` : ""))
      .join("");
  /** @type {Array<[string, string]>} */
  const paths = [
    ...levels.map(([reward]) => [reward === 0 ? "zero" : "level", `M0 ${y(reward)}H${WIDE}`]),
    ["ghost", line(ghost)],
    ["learned", line(learned)],
    ["greedy", between(false)],
    ["greedy far", between(true)],
    // A line of no length has round ends, which no stretching makes oval.
    ["greedy dots", dots.map((dot) => `M${dot}h0`).join("")],
  ];
  return paths.filter(([, path]) => path);
};

/**
 * @param {HTMLElement} row
 * @param {Bar} bar
 */
export const drawCurve = (row, bar) => {
  const up = heightOf(bar.rewards);
  const numbers = bar.levels.map(([reward, text]) => {
    const number = document.createElement("span");
    number.style.bottom = percent(up(reward));
    number.textContent = text;
    return number;
  });
  row.querySelector(".numbers")?.replaceChildren(...numbers);
  const paths = pathsOf(bar).map(([kind, d]) => {
    const path = document.createElementNS(SVG, "path");
    path.setAttribute("class", kind);
    path.setAttribute("d", d);
    return path;
  });
  row.querySelector("svg")?.replaceChildren(...paths);
};
