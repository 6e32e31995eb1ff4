// @ts-check
// What the lab asks on the bar of its own page, and what a hand there answers.

import { on, send, sendNewest } from "../player/pipe.js";
import { answerTo, askOnBar, gripOf, isOpen } from "./guess.js";
import { leaveTo } from "./hand.js";

on("ask", ({ ask }) => {
  askOnBar(ask);
  leaveTo(isOpen() ? gripOf : null);
});

answerTo((answer, isMoving) => {
  const say = isMoving ? sendNewest : send;
  say(typeof answer === "number" ? { do: "guess", trial: answer } : { do: "sketch", points: answer });
});

// Keys of time go nowhere while the bar is for the answer. They come to the window itself.
window.addEventListener(
  "pounce-key",
  (event) => {
    if (isOpen()) event.stopImmediatePropagation();
  },
  { capture: true },
);
