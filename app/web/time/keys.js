// @ts-check
// Keys of time. Which they are, and that they act at all, is judged by the page around the frame
// (../keys.js), wherever they are pressed; here is what each of them does.

import { goBy } from "./scrub.js";
import { ACTS } from "./transport.js";

/** What each does, by its place on the keyboard. @type {Record<string, () => unknown>} */
export const KEYS = {
  Home: ACTS.begin,
  End: ACTS.live,
  Comma: () => goBy("steps", -1),
  Period: () => goBy("steps", 1),
  "Shift+Comma": () => goBy("trials", -1),
  "Shift+Period": () => goBy("trials", 1),
  BracketLeft: ACTS.previous,
  BracketRight: ACTS.next,
  KeyA: ACTS.a,
  KeyB: ACTS.mark,
  KeyL: ACTS.loop,
};

window.addEventListener("pounce-key", (event) => {
  KEYS[/** @type {CustomEvent<string>} */ (event).detail]?.();
});
