// @ts-check
// What is what in the pictures of a reveal: a guess is hollow, a run is full, and many are pale.

import { element } from "../time/dom.js";
import { svgElement } from "./compass.js";
import { word } from "./words.js";

/** @typedef {"guess" | "saw" | "run" | "twenty" | "before" | "class"} Whose */

/** Of whom there are many; what the class chose first stands before what it chose then. */
export const MANY = /** @type {const} */ (["twenty", "before", "class"]);

/** @param {Whose} whose */
export const swatch = (whose) => {
  const svg = svgElement("svg", { viewBox: "0 0 16 16", class: `swatch ${whose}`, "aria-hidden": "true" });
  svg.append(svgElement("path", { d: SHAPES[whose], class: `of-${whose}` }));
  return svg;
};

/** Round a middle of 8, 8, so that they are told from each other without their colours. */
export const SHAPES = {
  guess: "M8 1.500L14.500 13.500H1.500Z",
  saw: "M1 8Q8 1.500 15 8Q8 14.500 1 8ZM8 6A2 2 0 1 0 8.010 6Z",
  run: "M8 1L15 8L8 15L1 8Z",
  twenty: "M8 3.500A4.500 4.500 0 1 1 7.990 3.500Z",
  before: "M3.500 3.500H12.500V12.500H3.500Z",
  class: "M3.500 3.500H12.500V12.500H3.500Z",
};

/**
 * A row of the list that says in words what the picture shows.
 * @param {Whose} whose
 * @param {string} name
 * @param {string} value
 */
export const row = (whose, name, value) => {
  const made = element("div", "said");
  const term = element("dt", "");
  term.append(swatch(whose), name);
  made.append(term, element("dd", "", value));
  return made;
};

/** What it is called. @param {Whose} whose @param {{n: number} | null} [many] */
export const nameOf = (whose, many) => word(whose, many?.n ?? 0);
