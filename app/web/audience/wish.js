// @ts-check
// What this page wishes to see. Besides, it sends what a class answers (`ask.js`).

import { sendNewest } from "../player/pipe.js";
import { isDark, whenScheme } from "../player/scheme.js";

/** `step` is null for what is newest. */
export const wish = {
  follows: true,
  layer: "value",
  of: 0,
  frame: -1,
  /** @type {number | null} */
  step: null,
};

/** Say what is wished now. */
export const say = () => {
  const { follows, layer, of, frame, step } = wish;
  const dark = isDark();
  sendNewest(follows ? { do: "follow", dark } : { do: "look", dark, layer, of, frame, step });
};

whenScheme(say);
