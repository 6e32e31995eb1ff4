// @ts-check
// How a run's line looks, wherever it is named: colour, width and dashes together.

/** @typedef {import("./state.js").Look} Look */

const SVG = "http://www.w3.org/2000/svg";

/**
 * Let a line look like that of a run.
 * @param {SVGElement} line
 * @param {Look} look
 */
export const dressLine = (line, { light, dark, width, dashes }) => {
  line.style.setProperty("--on-light", light);
  line.style.setProperty("--on-dark", dark);
  line.style.strokeWidth = `calc(${width}px * var(--stage-zoom, 1))`;
  line.style.strokeDasharray = dashes.length ? dashes.join(" ") : "none";
};

/** A piece of a run's line. @param {Look} look */
export const swatch = (look) => {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("class", "swatch");
  svg.setAttribute("viewBox", "0 0 34 8");
  svg.setAttribute("aria-hidden", "true");
  const line = document.createElementNS(SVG, "path");
  line.setAttribute("class", "run-line");
  line.setAttribute("d", "M1 4H33");
  dressLine(line, look);
  svg.append(line);
  return svg;
};
