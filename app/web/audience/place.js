// @ts-check
// A class answers on the picture itself: octants by a tap on the board, a moment by a tap on the time bar.
// What is answered there is the same as on the card, which has all of it for the keyboard.

import { OCTANTS, drawOctants, octantAt } from "../player/octants.js";
import { word } from "../lesson/words.js";
import { answerTo, askOnBar, gripOf, isOpen } from "../time/guess.js";
import { time } from "./bar.js";
import { board, canvas } from "./board.js";

/** @typedef {import("./ask.js").Ask} Ask */
/** @typedef {import("./ask.js").Outcome} Outcome */
/** @typedef {import("./ask.js").Value} Value */
/** @typedef {(value: Value) => void} Give */

/** What a tap on the board changes; null if nothing. @type {{chosen: string[], give: Give} | null} */
let open = null;

/** How many of a class chose each. @param {any} found */
const sharesOf = (found) =>
  found?.n ? Object.fromEntries(OCTANTS.map((octant) => [octant, (found.counts[octant] ?? 0) / found.n])) : null;

/**
 * Show what is asked, what one answers, and what came of it, where it is answered.
 * @param {Ask | null} ask
 * @param {Value | null} answer
 * @param {Outcome | null} reveal
 * @param {Give} give
 */
export const showInPlace = (ask, answer, reveal, give) => {
  const canGive = ask?.open ?? false;
  open = null;
  if (ask?.kind === "sectors") {
    const guess = Array.isArray(answer) ? answer : [];
    const names = Object.fromEntries(OCTANTS.map((octant) => [octant, word(octant)]));
    if (canGive) open = { chosen: guess, give };
    const shares = sharesOf(reveal?.class);
    const percent = (/** @type {number} */ share) => word("percent", Math.round(100 * share));
    const asked = { guess, locked: !canGive, run: reveal?.run ?? null, shares, names, percent };
    board.above((context, place, sent) => drawOctants(context, place, sent, board.heading ?? 0, asked));
  } else board.above(null);
  canvas.toggleAttribute("data-asked", open !== null);
  answerTo((trial, isMoving) => isMoving || give(/** @type {number} */ (trial)));
  if (ask?.kind !== "moment") return askOnBar(null);
  const { twenty } = reveal ?? {};
  askOnBar({
    kind: "moment",
    id: `${ask.ballot}`,
    language: ask.language,
    from: ask.low,
    to: ask.high,
    guess: typeof answer === "number" ? answer : null,
    locked: !canGive,
    run: typeof reveal?.run === "number" ? reveal.run : null,
    twenty: twenty?.values ?? [],
    runs: twenty?.n ?? 0,
  });
};

canvas.addEventListener("click", ({ clientX, clientY }) => {
  const heading = board.heading;
  const cell = board.cellAt(clientX, clientY);
  const octant = cell && heading !== null && octantAt(cell, heading);
  if (!open || !octant) return;
  const { chosen, give } = open;
  give(OCTANTS.filter((each) => chosen.includes(each) !== (each === octant)));
});

/** What has the pointer. @type {import("../time/hand.js").Grip | null} */
let grip = null;

// Before whoever looks around, who has the bar otherwise.
time.addEventListener(
  "pointerdown",
  (event) => {
    if (!isOpen() || event.button !== 0 || !event.isPrimary) return;
    event.stopImmediatePropagation();
    grip = gripOf(event);
    if (!grip) return;
    time.setPointerCapture(event.pointerId);
    grip.move(event);
  },
  { capture: true },
);
time.addEventListener("pointermove", (event) => grip?.move(event));
time.addEventListener("pointerup", () => {
  grip?.release();
  grip = null;
});
time.addEventListener("pointercancel", () => {
  grip?.giveUp();
  grip = null;
});
