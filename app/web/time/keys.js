// @ts-check
// Keys of time. Which they are, and that they act at all, is judged by the page around the frame
// (../keys.js), wherever they are pressed; here is what each of them does.

import { send } from "./channel.js";
import { goBy } from "./scrub.js";
import { ACTS } from "./transport.js";

/** @type {Record<string, () => unknown>} */
const KEYS = {
  Home: () => send({ do: "seek", step: 0 }),
  End: () => send({ do: "live" }),
  Comma: () => goBy("steps", -1),
  Period: () => goBy("steps", 1),
  "Shift+Comma": () => goBy("trials", -1),
  "Shift+Period": () => goBy("trials", 1),
  BracketLeft: () => goBy("events", -1),
  BracketRight: () => goBy("events", 1),
  KeyA: () => send({ do: "set_a" }),
  KeyB: () => ACTS.mark(document.body),
  KeyL: () => ACTS.loop(document.body),
};

window.addEventListener("pounce-key", (event) => {
  KEYS[/** @type {CustomEvent<string>} */ (event).detail]?.();
});
