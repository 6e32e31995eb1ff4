// @ts-check
// The page in the frame.
import { on } from "./channel.js";
import "./draw.js";
import { changed, state } from "./state.js";
import "./theme.js";

on("bar", ({ bar }) => {
  state.bar = bar;
  changed();
});
on("moment", (moment) => {
  state.moment = moment;
  changed();
});
