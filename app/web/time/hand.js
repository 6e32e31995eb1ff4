// @ts-check
// What a hand does with a pointer: one thing has it until it lets go, and what it does is asked for
// then. Mouse, finger and pen alike.

import { blockGrip } from "./edit.js";
import "./keys.js";
import "./menu.js";
import { playheadGrip } from "./scrub.js";
import { changed, state } from "./state.js";
import "./transport.js";

/**
 * Something that a pointer has taken hold of.
 * @typedef {{
 *   isAtOnce: boolean,
 *   move: (event: PointerEvent) => void,
 *   release: () => void,
 *   tap: (event: PointerEvent) => void,
 *   giveUp: () => void,
 * }} Grip `isAtOnce` where it moves as soon as the pointer is down; else a pointer that hardly moves
 *   has only tapped
 */

/** A pointer that moves no farther has not been moved on purpose. */
const STILL_PX = 4;

const root = document.body;

/** @typedef {(event: PointerEvent) => Grip | null} Take What takes hold of something, if it does. */
/** What takes all that a pointer comes down on, as long as there is such a thing. @type {Take | null} */
let only = null;

/**
 * Let one thing have the pointer, and no other, until that is over.
 * @param {Take | null} take
 */
export const leaveTo = (take) => void (only = take);
/** @type {{grip: Grip, pointer: number, x: number, y: number, isMoving: boolean} | null} */
let holding = null;

/** @param {boolean} isMoving */
const setMoving = (isMoving) => {
  state.held = isMoving;
  root.toggleAttribute("data-holding", isMoving);
  changed();
};

/** @param {PointerEvent} event */
const begin = (event) => {
  if (!holding) return;
  holding.isMoving = true;
  // From here on all comes here, wherever the pointer goes, even out of the frame.
  root.setPointerCapture(event.pointerId);
  setMoving(true);
  holding.grip.move(event);
};

const letGo = () => {
  const held = holding;
  holding = null;
  if (held?.isMoving) setMoving(false);
  return held;
};

const giveUp = () => letGo()?.grip.giveUp();

root.addEventListener("pointerdown", (event) => {
  if (event.button !== 0 || !event.isPrimary) return;
  // One that came up elsewhere is not told of.
  giveUp();
  const grip = only ? only(event) : (blockGrip(event) ?? playheadGrip(event));
  if (!grip) return;
  // What was being typed is finished by that.
  const focused = document.activeElement;
  if (focused instanceof HTMLInputElement) focused.blur();
  const { pointerId: pointer, clientX: x, clientY: y } = event;
  holding = { grip, pointer, x, y, isMoving: false };
  // A finger may be about to scroll the page.
  if (grip.isAtOnce && event.pointerType !== "touch") begin(event);
});

// What is taken hold of takes the focus itself; nothing else does, and no text is chosen.
root.addEventListener("mousedown", (event) => {
  if (holding) event.preventDefault();
});

root.addEventListener("pointermove", (event) => {
  if (holding?.pointer !== event.pointerId) return;
  if (!event.buttons) return giveUp();
  if (holding.isMoving) return holding.grip.move(event);
  const { x, y } = holding;
  if (Math.hypot(event.clientX - x, event.clientY - y) > STILL_PX) begin(event);
});

root.addEventListener("pointerup", (event) => {
  if (holding?.pointer !== event.pointerId) return;
  const { grip, isMoving } = /** @type {NonNullable<typeof holding>} */ (letGo());
  if (isMoving) grip.release();
  else grip.tap(event);
});

root.addEventListener("pointercancel", ({ pointerId }) => {
  if (holding?.pointer === pointerId) giveUp();
});
root.addEventListener("lostpointercapture", ({ pointerId, target }) => {
  // What a finger came down on has it at first, and loses it to all of the page.
  if (holding?.pointer === pointerId && target === root) giveUp();
});

window.addEventListener(
  "keydown",
  (event) => {
    if (event.key !== "Escape" || !holding) return;
    event.preventDefault();
    event.stopPropagation();
    giveUp();
  },
  true,
);
