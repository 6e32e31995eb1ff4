// @ts-check
// The time bar as it is told what it shows, by whatever the page hears (../player/pipe.js).
import { on } from "../player/pipe.js";
import "./draw.js";
import "./hand.js";
import { changed, state, whenChanged } from "./state.js";
import "./tip.js";

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
