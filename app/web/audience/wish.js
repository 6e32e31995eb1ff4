// @ts-check
// What this page wishes to see. Besides, it sends what a class answers (`ask.js`),
// and what is done with a learner of one's own (`own.js`).

import { sendNewest } from "../player/pipe.js";
import { isDark, whenScheme } from "../player/scheme.js";

/** `step` is null for what is newest. */
export const wish = {
  follows: true,
  /** Whether it is the learner of one's own, whatever else is wished. */
  own: false,
  layer: "value",
  of: 0,
  frame: -1,
  /** @type {number | null} */
  step: null,
};

/** Say what is wished now. */
export const say = () => {
  const { follows, own, layer, of, frame, step } = wish;
  const dark = isDark();
  if (own) sendNewest({ do: "own", dark });
  else sendNewest(follows ? { do: "follow", dark } : { do: "look", dark, layer, of, frame, step });
};

whenScheme(say);
