// @ts-check
// One's own seat in a class: a number and a shape, and nothing else that anybody could know.

import { svgElement } from "../lesson/compass.js";
import { element } from "../time/dom.js";
import { word } from "./words.js";

/** @typedef {{number: number, shape: string}} Seat */

/** Round a middle of 8, 8. @type {Record<string, string>} */
const SHAPES = {
  circle: "M8 1.500A6.500 6.500 0 1 1 7.990 1.500Z",
  triangle: "M8 1.500L15 14H1Z",
  square: "M2 2H14V14H2Z",
  star: "M8 .5L10 5.800L15.500 6L11.200 9.500L12.700 15L8 11.800L3.300 15L4.800 9.500L.5 6L6 5.800Z",
  diamond: "M8 .5L14.500 8L8 15.500L1.500 8Z",
  cross: "M5.500 1H10.500V5.500H15V10.500H10.500V15H5.500V10.500H1V5.500H5.500Z",
};

/**
 * Show whose a page is.
 * @param {HTMLElement} place
 * @param {Seat | null} seat
 */
export const showSeat = (place, seat) => {
  const key = seat ? `${seat.number} ${word(seat.shape)}` : "";
  if (place.dataset.seat === key) return;
  place.dataset.seat = key;
  place.hidden = !seat;
  if (!seat) return;
  const shape = svgElement("svg", { viewBox: "0 0 16 16", "aria-hidden": "true" });
  shape.append(svgElement("path", { d: SHAPES[seat.shape] ?? SHAPES.circle }));
  const named = element("span", "", `${seat.number}, ${word(seat.shape)}`);
  place.replaceChildren(element("span", "unseen", word("seat")), shape, named);
};
