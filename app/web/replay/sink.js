// @ts-check
// What the lab is to the time bar elsewhere: here it is this page that takes what a hand does.

import { connectTo, hear } from "../player/pipe.js";

/** @typedef {import("./walk.js").Walk} Walk */
/** @typedef {import("../time/state.js").Bar} Bar */

const FIXED = "This is a recording: nothing of it can be changed.";

/**
 * What each message does; what is none of these would change the run.
 * @type {Record<string, (walk: Walk, message: any) => unknown>}
 */
const DEEDS = {
  seek: (walk, { step }) => walk.seek("step", step),
  seek_trial: (walk, { trial }) => walk.seek("trial", trial),
  live: (walk) => walk.end(),
  look: (walk, { line }) => walk.look(line),
  play: (walk, { direction }) => walk.play(direction),
  pause: (walk) => void (walk.direction = 0),
  rate: (walk, { rate }) => void (walk.rate = rate),
  by: (walk, { unit, n }) => walk.by(unit, n),
  set_a: (walk) => walk.setA(),
  loop: (walk, { on }) => walk.setLoop(on),
  stops: (walk, { on }) => void (walk.stops = on),
  choose: () => {},
};

/**
 * Let the time bar show a walk, and move it.
 * @param {Walk} walk
 * @param {Map<number, Record<string, Bar>>} bars of each line, by what their axis is of
 * @param {() => void} show what is to be shown of the moment that is looked at
 */
export const follow = (walk, bars, show) => {
  let unit = "trials";
  let [shown, told, last] = ["", "", 0];

  const tell = () => {
    const of = `${walk.line} ${unit}`;
    if (of !== shown) hear({ kind: "bar", bar: bars.get(walk.line)?.[unit] });
    shown = of;
    const { moment } = walk;
    const now = JSON.stringify(moment);
    if (now !== told) hear({ kind: "moment", ...moment });
    told = now;
    show();
  };

  /** @param {number} now */
  const frame = (now) => {
    if (!walk.direction) return;
    walk.go(Math.min((now - last) / 1000, 0.5));
    last = now;
    tell();
    requestAnimationFrame(frame);
  };

  connectTo({
    send: (message) => {
      const isPlaying = walk.direction !== 0;
      if (message.do === "unit") ({ unit } = message);
      else if (!(message.do in DEEDS)) hear({ kind: "said", text: FIXED, refused: true });
      else {
        const why = DEEDS[message.do](walk, message);
        if (typeof why === "string" && why) hear({ kind: "said", text: why, refused: true });
      }
      tell();
      if (walk.direction && !isPlaying) {
        last = performance.now();
        requestAnimationFrame(frame);
      }
      return true;
    },
  });
  tell();
};
