// @ts-check
// Looking around: a layer, headings and a moment of one's own, and back to what the presenter shows.

import { on } from "../player/pipe.js";
import { stepAt } from "../time/axis.js";
import { plotBox } from "../time/draw.js";
import { state } from "../time/state.js";
import { time } from "./bar.js";
import { say, wish } from "./wish.js";

/**
 * @typedef {{key: string, title: string, of: string[], headings: boolean}} Layer
 * @typedef {{layers: Layer[], headings: Array<[number, string]>}} Offer
 */

/** Of the whole line, for an arrow key. */
const SMALL = 1 / 100;

/** @template {HTMLElement} T @param {string} id */
const part = (id) => /** @type {T} */ (document.getElementById(id));

const follow = part("follow");
const around = part("around");
const mine = part("mine");
const choices = part("choices");
const steps = part("steps");
const layer = /** @type {HTMLSelectElement} */ (part("layer"));
const of = /** @type {HTMLSelectElement} */ (part("of"));
const headings = /** @type {HTMLSelectElement} */ (part("headings"));
const handle = /** @type {HTMLElement} */ (time.querySelector(".handle"));

/** @type {Offer} */
let offer = { layers: [], headings: [] };
let offered = "";

/** @param {HTMLSelectElement} select @param {Array<[string | number, string]>} options @param {string | number} chosen */
const fill = (select, options, chosen) => {
  select.replaceChildren(...options.map(([value, text]) => new Option(text, `${value}`)));
  select.value = `${chosen}`;
};

/** Show what is wished, and what there is to choose for it. */
const show = () => {
  const { follows, own } = wish;
  follow.setAttribute("aria-pressed", `${follows && !own}`);
  follow.textContent = follows || own ? "Presenter" : "Back to presenter";
  around.setAttribute("aria-pressed", `${!follows && !own}`);
  mine.setAttribute("aria-pressed", `${own}`);
  document.documentElement.toggleAttribute("data-around", !follows && !own);
  document.documentElement.toggleAttribute("data-own", own);
  choices.hidden = follows;
  steps.hidden = follows;
  handle.tabIndex = follows ? -1 : 0;
  handle.setAttribute("aria-disabled", `${follows}`);
  const chosen = offer.layers.find(({ key }) => key === wish.layer) ?? offer.layers[0];
  if (!chosen) return;
  fill(layer, offer.layers.map(({ key, title }) => [key, title]), chosen.key);
  fill(of, chosen.of.map((name, index) => [index, name]), Math.min(wish.of, chosen.of.length - 1));
  fill(headings, offer.headings, wish.frame);
  /** @type {HTMLElement} */ (of.parentElement).hidden = chosen.of.length < 2;
  /** @type {HTMLElement} */ (headings.parentElement).hidden = !chosen.headings;
};

on("offer", (told) => {
  const text = JSON.stringify(told);
  if (text === offered) return;
  offered = text;
  offer = told;
  show();
});

/** @param {boolean} follows */
const turn = (follows) => {
  // One begins where the presenter is, and with the same layer if it is made for all.
  const theirs = offer.layers.find(({ title }) => title === part("title").textContent);
  if (!follows && wish.follows && theirs) wish.layer = theirs.key;
  wish.follows = follows;
  wish.own = false;
  if (follows || !state.moment) wish.step = null;
  else wish.step = state.moment.live ? null : state.moment.step;
  show();
  say();
};

follow.addEventListener("click", () => turn(true));
around.addEventListener("click", () => turn(false));
mine.addEventListener("click", () => {
  wish.own = true;
  show();
  say();
});

choices.addEventListener("change", () => {
  wish.layer = layer.value;
  wish.of = Math.max(Number(of.value), 0);
  wish.frame = Number(headings.value);
  show();
  say();
});

// --- A moment of one's own -------------------------------------------------------------------------

/** @param {number | null} step */
const go = (step) => {
  const end = state.bar?.end.step ?? 0;
  wish.step = step === null || (step >= end && state.bar?.live) ? null : Math.max(step, 0);
  say();
};

/** Where one is. */
const here = () => wish.step ?? state.moment?.step ?? state.bar?.end.step ?? 0;

/** @param {1 | -1} direction */
const goByEvent = (direction) => {
  const events = (state.bar?.happenings ?? []).map(({ step }) => step);
  if (direction > 0) go(events.find((step) => step > here()) ?? null);
  else go(events.findLast((step) => step < here()) ?? 0);
};

/** @type {Record<string, () => void>} */
const GO = {
  begin: () => go(0),
  previous: () => goByEvent(-1),
  next: () => goByEvent(1),
  now: () => go(null),
};

steps.addEventListener("click", ({ target }) => {
  GO[/** @type {HTMLElement} */ (target).dataset.go ?? ""]?.();
});

handle.addEventListener("keydown", (event) => {
  if (wish.follows || !state.bar) return;
  const by = Math.max(Math.round(state.bar.end.step * SMALL), 1);
  /** @type {Record<string, () => void>} */
  const keys = {
    ArrowLeft: () => go(here() - by),
    ArrowRight: () => go(here() + by),
    PageUp: GO.next,
    PageDown: GO.previous,
    Home: GO.begin,
    End: GO.now,
  };
  const act = keys[event.key];
  if (!act) return;
  event.preventDefault();
  act();
});

window.addEventListener("keydown", (event) => {
  if (event.key === "Escape" && (wish.own || !wish.follows)) turn(true);
});

/** @param {PointerEvent} event */
const goToPointer = ({ clientX }) => {
  if (!state.bar) return;
  const { left, width } = plotBox();
  go(stepAt(state.bar.axis, (clientX - left) / width));
};

let isHeld = false;
time.addEventListener("pointerdown", (event) => {
  if (wish.follows || event.button !== 0 || !event.isPrimary) return;
  const sign = /** @type {HTMLElement | null} */ (/** @type {Element} */ (event.target).closest(".event"));
  if (sign) return go(Number(sign.dataset.step));
  isHeld = true;
  time.setPointerCapture(event.pointerId);
  goToPointer(event);
});
time.addEventListener("pointermove", (event) => {
  if (isHeld) goToPointer(event);
});
for (const end of ["pointerup", "pointercancel"]) time.addEventListener(end, () => (isHeld = false));

/** Begin with what the presenter shows. */
export const begin = () => {
  steps.before(time);
  show();
  say();
};
