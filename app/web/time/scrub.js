// @ts-check
// The playhead in a hand: anywhere on the curve, the axis, and where lanes are empty.

import { roundest, shareOf, stepAt, stepOfTrial, trialAt, trialOfStep } from "./axis.js";
import { send, sendNewest } from "../player/pipe.js";
import { plotBox, shareAt } from "./draw.js";
import { changed, state, whenChanged } from "./state.js";

/** @typedef {import("./hand.js").Grip} Grip */
/** @typedef {import("./state.js").Place} Place */

/** Things with a pointer of their own. */
const OTHERS = "a, button, input, select, textarea, .piece, .line, [role=menu]";
/** So long the playhead waits where a hand has let it go, unless it is shown there before. */
const PATIENCE_MS = 1_500;
const FEW_TRIALS = 100;
const MANY_TRIALS = 1_000;

/** What was asked for last, until it is shown. @type {Wish | null} */
let wished = null;
let timer = 0;
/** @typedef {{do: "live"} | {do: "seek", step: number} | {do: "seek_trial", trial: number}} Wish */

/** Where what is looked at ends: now, if it is the live run. */
const end = () => {
  const { bar, moment } = state;
  if (!bar || !moment) return { trial: 0, step: 0 };
  if (!bar.live) return bar.end;
  // A bar is seldom sent; how far it is to now is told with each moment.
  const [trials, steps] = moment.live ? [0, 0] : [moment.behind_trials, moment.behind_steps];
  return { trial: moment.trial + trials, step: moment.step + steps };
};

/**
 * The moment at a place of the axis, none beyond what is known.
 * @param {number} share
 * @returns {{place: Place, wish: Wish, isBeyond: boolean} | null}
 */
const wishAt = (share) => {
  if (!state.bar) return null;
  const { axis, line, live } = state.bar;
  const last = end();
  const isTrials = axis.unit === "trials";
  const pointed = isTrials ? trialAt(axis, share) : stepAt(axis, share);
  const at = roundest(pointed, (axis.end - (axis.start ?? 0)) / (plotBox().width || 1));
  const isBeyond = at >= (isTrials ? last.trial : last.step);
  if (isBeyond) return { place: last, wish: live ? { do: "live" } : { do: "seek", step: last.step }, isBeyond };
  if (isTrials) {
    const place = { trial: at, step: Math.round(stepOfTrial(axis, at)) };
    return { place, wish: { do: "seek_trial", trial: at }, isBeyond };
  }
  return {
    place: { trial: Math.floor(trialOfStep(axis, at)), step: at },
    wish: { do: "seek", step: at },
    isBeyond,
  };
};

/** Whether what is looked at is what was wished for. */
const isThere = () => {
  const { moment } = state;
  // What is recorded is shown at once, and at the nearest of its moments.
  if (!wished || !moment || state.bar?.recorded) return true;
  if (wished.do === "live") return moment.live;
  return wished.do === "seek" ? moment.step === wished.step : moment.trial === wished.trial;
};

const put = (/** @type {Place | null} */ place) => {
  clearTimeout(timer);
  timer = 0;
  state.scrub = place;
  changed();
};

whenChanged(() => {
  if (timer && isThere()) put(null);
});

/**
 * Look at what is at a place of the axis. While a hand moves, of several wishes in a moment only the
 * last counts.
 * @param {number} share
 */
const look = (share) => {
  const found = wishAt(share);
  if (!found) return;
  put(found.place);
  if (JSON.stringify(wished) !== JSON.stringify(found.wish)) sendNewest(found.wish);
  wished = found.wish;
};

/** Where a hand lets go of the playhead, it stays until that moment is shown. */
const leaveThere = () => {
  if (!state.scrub) return;
  timer = setTimeout(() => put(null), PATIENCE_MS);
  changed();
};

/** How to go back to what was looked at. @returns {Wish | null} */
const wayBack = () => {
  const { moment } = state;
  if (!moment) return null;
  return moment.live ? { do: "live" } : { do: "seek", step: moment.step };
};

let presses = 0;
/** Of the last two presses those that have moved something, with how to go back from that. @type {Array<{press: number, back: Wish | null}>} */
let moves = [];

/** What the two presses of a double click have moved is where it was before the first of them. */
export const takeBackPresses = () => {
  // The browser knows what a double click is, however far apart its presses are.
  const before = moves.find(({ press }) => press > presses - 2)?.back ?? null;
  moves = [];
  if (before) send(before);
  wished = before;
  put(null);
};

/**
 * @param {PointerEvent} event
 * @returns {Grip | null}
 */
export const playheadGrip = (event) => {
  const target = /** @type {Element} */ (event.target);
  const isHead = target.closest(".playhead") !== null;
  if (!isHead && (!target.closest(".plot") || target.closest(OTHERS))) return null;
  if (!state.bar || !state.moment) return null;
  const back = wayBack();
  presses += 1;
  const press = presses;
  const first = wishAt(shareAt(event));
  // Where nothing is known yet there is nothing to look at; what is to come may be planned there.
  const isAhead = !isHead && (first?.isBeyond ?? true);
  // Who takes it by its head, beside its line, does not mean to move it by that.
  const { axis } = state.bar;
  const off = isHead ? shareAt(event) - shareOf(axis, state.scrub ?? state.moment) : 0;
  let isMoved = false;
  const begin = () => {
    // Whatever was wished before, another hand or the keys may have gone elsewhere since.
    wished = null;
    aim = null;
    /** @type {HTMLElement | null} */ (document.querySelector(".playhead .handle"))?.focus({
      preventScroll: true,
    });
    moves = [...moves.slice(-1), { press, back }];
  };
  return {
    isAtOnce: !isAhead,
    move: (at) => {
      if (!isMoved) begin();
      isMoved = true;
      look(shareAt(at) - off);
    },
    release: leaveThere,
    tap: (at) => {
      if (isHead || isAhead) return;
      begin();
      look(shareAt(at));
      leaveThere();
    },
    giveUp: () => {
      if (back) send(back);
      wished = back;
      put(null);
    },
  };
};

/**
 * Go on, or back, from what is looked at.
 * @param {"steps" | "trials" | "events"} unit
 * @param {number} n
 */
export const goBy = (unit, n) => {
  aim = null;
  put(null);
  send({ do: "by", unit, n });
};

/** Where a key is on the way to, and since when. @type {{trial: number, since: number} | null} */
let aim = null;

/**
 * Go to the next round trial, on or back: of keys that are pressed faster than moments are shown, each
 * goes on from where the last one went.
 * @param {1 | -1} direction
 * @param {number} unit
 */
const goToRound = (direction, unit) => {
  const { moment, bar } = state;
  if (!moment || !bar) return;
  const last = end();
  const isOnTheWay = aim !== null && performance.now() - aim.since < PATIENCE_MS;
  // Where a hand has just let it go it is, though that may not be shown yet.
  const from = aim && isOnTheWay ? aim.trial : (state.scrub ?? moment).trial;
  const round = direction > 0 ? Math.floor(from / unit) + 1 : Math.ceil(from / unit) - 1;
  const trial = Math.max(round * unit, 0);
  const isBeyond = trial >= last.trial;
  put(null);
  aim = { trial: Math.min(trial, last.trial), since: performance.now() };
  if (!isBeyond) send({ do: "seek_trial", trial });
  else send(bar.live ? { do: "live" } : { do: "seek", step: last.step });
};

/** By key: round trials with arrows, the ends with theirs. */
document.body.addEventListener("keydown", (event) => {
  const target = /** @type {Element} */ (event.target);
  if (!target.closest(".playhead") || event.ctrlKey || event.metaKey || event.altKey) return;
  const many = event.shiftKey ? MANY_TRIALS : FEW_TRIALS;
  const acts = /** @type {Record<string, () => unknown>} */ ({
    ArrowLeft: () => goToRound(-1, many),
    ArrowDown: () => goToRound(-1, many),
    ArrowRight: () => goToRound(1, many),
    ArrowUp: () => goToRound(1, many),
    PageDown: () => goToRound(-1, MANY_TRIALS),
    PageUp: () => goToRound(1, MANY_TRIALS),
    Home: () => send({ do: "seek", step: 0 }),
    End: () => send({ do: "live" }),
  });
  const act = acts[event.key];
  if (!act) return;
  event.preventDefault();
  event.stopPropagation();
  if (!/^(Arrow|Page)/.test(event.key)) aim = null;
  act();
});

// What one can go to by a click: what happened, the end of what is known, and the axis of the other unit.
document.body.addEventListener("click", ({ target }) => {
  const node = /** @type {HTMLElement | null} */ (
    /** @type {Element} */ (target).closest(".event, .live-end, .unit")
  );
  if (!node) return;
  const { step, unit } = node.dataset;
  aim = null;
  put(null);
  if (unit) send({ do: "unit", unit });
  else if (step) send({ do: "seek", step: Number(step) });
  else send({ do: "live" });
});
