// @ts-check
// The page in the frame, without the way by which it hears from the lab.
import "../time/theme.js";
import { on } from "../player/pipe.js";
import "./card.js";
import "./learn.js";
import "./outer.js";
import { changed, state } from "./state.js";

on("lesson", (told) => {
  // Another lesson has begun, here or in another browser.
  if (told.lesson?.name !== state.told?.lesson?.name) state.listing = false;
  state.told = told;
  changed();
});
