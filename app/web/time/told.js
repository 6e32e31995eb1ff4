// @ts-check
// What is told of a line and of a moment becomes what is shown.

import { on } from "../player/pipe.js";
import { changed, state, whenChanged } from "./state.js";

/** The newest bar, as long as a hand holds something: no axis is to move under that. @type {import("./state.js").Bar | null} */
let waiting = null;

on("bar", ({ bar }) => {
  if (state.held) waiting = bar;
  else state.bar = bar;
  changed();
});
on("moment", (moment) => {
  state.moment = moment;
  changed();
});
whenChanged(() => {
  if (!waiting || state.held) return;
  state.bar = waiting;
  waiting = null;
  changed();
});
