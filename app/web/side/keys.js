// @ts-check
// Keys. Which they are, and that they act at all, is judged by the page around the frame
// (../keys.js), wherever they are pressed; here is what each of them does.

import { send } from "../player/pipe.js";
import { ACTS } from "./head.js";

/** @type {Record<string, () => unknown>} */
const KEYS = {
  Space: ACTS.play,
  KeyS: () => send({ do: "step" }),
  KeyJ: () => send({ do: "faster", by: -5 }),
  KeyK: () => send({ do: "faster", by: 5 }),
  Home: () => send({ do: "seek", step: 0 }),
  End: () => send({ do: "live" }),
  Comma: () => send({ do: "by", unit: "steps", n: -1 }),
  Period: () => send({ do: "by", unit: "steps", n: 1 }),
  BracketLeft: () => send({ do: "by", unit: "events", n: -1 }),
  BracketRight: () => send({ do: "by", unit: "events", n: 1 }),
};

window.addEventListener("pounce-key", (event) => {
  KEYS[/** @type {CustomEvent<string>} */ (event).detail]?.();
});
