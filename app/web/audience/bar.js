// @ts-check
// The time bar of those who only look: nothing of it can be changed, and it does not say that it could.

import "../time/draw.js";
import { whenChanged } from "../time/state.js";
import "../time/told.js";

/** The time bar's element. */
export const time = /** @type {HTMLElement} */ (document.querySelector(".time"));

whenChanged(() => {
  for (const piece of /** @type {Iterable<HTMLElement>} */ (time.querySelectorAll(".piece"))) {
    // What follows in a hint says how to change it.
    const [what, ...how] = piece.title.split("\n");
    if (!how.length) continue;
    piece.title = what;
    piece.setAttribute("role", "img");
    piece.tabIndex = -1;
    for (const name of ["disabled", "valuenow", "valuemin", "valuemax", "valuetext"]) piece.removeAttribute(`aria-${name}`);
  }
});
