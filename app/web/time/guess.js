// @ts-check
// What is asked on the bar: at which trial something will be, or how the curve will go. As long as that is
// open the bar is for the answer alone; afterwards guess, run and twenty runs are in one picture. Who gives
// pointers to it, and who hears of answers, is the page's own matter (asks.js, ../audience/place.js).

import { roundest, shareOfTrial, trialAt } from "./axis.js";
import { heightOf } from "./curve.js";
import { attribute } from "./dom.js";
import { plotBox, shareAt } from "./draw.js";
import { curve, drawAsked, ends, flag, knots, level, standing } from "./guessed.js";
import { changed, state, whenChanged } from "./state.js";

/** @typedef {import("./hand.js").Grip} Grip */
/** @typedef {import("./state.js").Bar} Bar */
/** @typedef {import("./state.js").Point} Point */
/** @typedef {import("./state.js").MomentAsked} MomentAsked */
/** @typedef {import("./state.js").SketchAsked} SketchAsked */
/** @typedef {number | Point[]} Answer A trial, or the points of a curve. */

/** So long what a hand made of the answer stands, unless it is told before. */
const PATIENCE_MS = 1_500;
const FEW_TRIALS = 100;
const MANY_TRIALS = 1_000;
const FEW_REWARD = 1;
const MUCH_REWARD = 10;
/** Beside the axis one still means its end. */
const BESIDE = 0.03;

/** What a hand made of the answer, until the lab says the same. @type {Answer | null} */
let mine = null;
let timer = 0;

/** Whether an answer can be given, or be made another. */
export const isOpen = () => state.ask !== null && !state.ask.locked;

// --- The answer ------------------------------------------------------------------------------------

const guess = () => /** @type {number | null} */ (mine ?? /** @type {MomentAsked} */ (state.ask).guess);
const drawn = () => {
  const { at, handles } = /** @type {SketchAsked} */ (state.ask);
  const points = /** @type {Point[] | null} */ (mine ?? handles);
  return points && at.map((trial, i) => /** @type {Point} */ ([trial, points[i]?.[1] ?? 0]));
};

/** @param {MomentAsked | SketchAsked} ask */
const answerIn = (ask) => (ask.kind === "moment" ? ask.guess : ask.handles);

/** @typedef {(answer: Answer, isMoving: boolean) => void} Give Hears of an answer. */
/** @type {Give} */
let give = () => {};

/**
 * Have answers given to somebody.
 * @param {Give} taker who is told as well whether another one comes in a moment
 */
export const answerTo = (taker) => void (give = taker);

/**
 * Take an answer that a hand gives.
 * @param {Answer} answer
 * @param {boolean} isMoving whether another one comes in a moment
 */
const take = (answer, isMoving = false) => {
  clearTimeout(timer);
  mine = answer;
  give(answer, isMoving);
  if (!isMoving) timer = setTimeout(forget, PATIENCE_MS);
  changed();
};

const forget = () => {
  clearTimeout(timer);
  mine = null;
  changed();
};

/**
 * Ask this from now on, or nothing any more.
 * @param {MomentAsked | SketchAsked | null} ask
 */
export const askOnBar = (ask) => {
  const isOther = state.ask?.id !== ask?.id || state.ask?.kind !== ask?.kind;
  state.ask = ask;
  const answer = ask && answerIn(ask);
  if (isOther || !isOpen() || JSON.stringify(answer) === JSON.stringify(mine)) forget();
  changed();
};

// --- By pointer ------------------------------------------------------------------------------------

/** @param {number} share */
const trialUnder = (share) => {
  const { axis } = /** @type {Bar} */ (state.bar);
  const apart = (axis.end - (axis.start ?? 0)) / (plotBox().width || 1);
  // Of steps, a pixel is some trials; of them, the roundest is meant as well.
  const trials = axis.unit === "trials" ? apart : 1;
  const [low, high] = ends(/** @type {MomentAsked} */ (state.ask), /** @type {Bar} */ (state.bar));
  return Math.min(Math.max(roundest(trialAt(axis, share), trials), low), high);
};

/** @returns {Grip} */
const flagGrip = () => {
  const before = guess();
  /** @type {number | null} */
  let last = null;
  const put = (/** @type {PointerEvent} */ event, /** @type {boolean} */ isMoving) => {
    flag.focus({ preventScroll: true });
    last = trialUnder(shareAt(event));
    take(last, isMoving);
  };
  return {
    isAtOnce: true,
    move: (event) => put(event, true),
    release: () => last !== null && take(last),
    tap: (event) => put(event, false),
    giveUp: () => (before === null ? forget() : take(before)),
  };
};

/**
 * The reward at a height of the window.
 * @param {{clientY: number}} event
 */
const rewardUnder = ({ clientY }) => {
  const { rewards } = /** @type {Bar} */ (state.bar);
  const [low, high] = rewards;
  const { bottom, height } = curve.getBoundingClientRect();
  const up = heightOf(rewards);
  const share = (bottom - clientY) / height;
  const reward = low + ((share - up(low)) / (up(high) - up(low))) * (high - low);
  return Math.round(Math.min(Math.max(reward, low), high));
};

/** @param {{clientX: number}} event */
const nearest = (event) => {
  const { axis } = /** @type {Bar} */ (state.bar);
  const share = shareAt(event);
  const { at } = /** @type {SketchAsked} */ (state.ask);
  const away = at.map((trial) => Math.abs(shareOfTrial(axis, trial) - share));
  return away.indexOf(Math.min(...away));
};

/** @returns {Grip} */
const curveGrip = () => {
  const before = drawn();
  const [ask, bar] = [/** @type {SketchAsked} */ (state.ask), /** @type {Bar} */ (state.bar)];
  /** Where it was last, and what is drawn by then. @type {{handle: number, reward: number, points: Point[]} | null} */
  let last = null;
  /** @param {PointerEvent} event @param {boolean} isMoving */
  const put = (event, isMoving) => {
    const [handle, reward] = [nearest(event), rewardUnder(event)];
    const points = drawn() ?? level(ask, bar);
    const from = last ?? { handle, reward };
    // A hand that is fast passes over some of them.
    const way = Math.abs(handle - from.handle);
    for (let step = 1; step < way; step++) {
      const passed = from.handle + Math.sign(handle - from.handle) * step;
      points[passed][1] = Math.round(from.reward + ((reward - from.reward) * step) / way);
    }
    points[handle][1] = reward;
    last = { handle, reward, points };
    /** @type {HTMLElement} */ (knots.children[handle])?.focus({ preventScroll: true });
    take(points, isMoving);
  };
  return {
    isAtOnce: true,
    move: (event) => put(event, true),
    release: () => last && take(last.points),
    tap: (event) => put(event, false),
    giveUp: () => (before === null ? forget() : take(before)),
  };
};

/**
 * What a pointer comes down on while something is asked is for the answer, and for nothing else.
 * @param {PointerEvent} event
 */
export const gripOf = (event) => {
  const target = /** @type {Element} */ (event.target);
  if (!state.bar || !state.ask) return null;
  const share = shareAt(event);
  if (state.ask.kind === "sketch") return target.closest(".curve > .plot") ? curveGrip() : null;
  const isBeside = share < -BESIDE || share > 1 + BESIDE;
  return target.closest(".rows") && (!isBeside || target.closest(".flag")) ? flagGrip() : null;
};

// --- By key ----------------------------------------------------------------------------------------

/**
 * Where a key leads, from a number; null if it is no key of a slider.
 * @param {KeyboardEvent} event
 * @param {number} from
 * @param {[number, number]} ends
 * @param {[number, number]} strides
 */
const goneTo = ({ key, shiftKey }, from, [low, high], [few, many]) => {
  const stride = shiftKey ? many : few;
  const up = (/** @type {number} */ by) => (Math.floor(from / by) + 1) * by;
  const down = (/** @type {number} */ by) => (Math.ceil(from / by) - 1) * by;
  const to = /** @type {Record<string, number>} */ ({
    ArrowRight: up(stride),
    ArrowUp: up(stride),
    ArrowLeft: down(stride),
    ArrowDown: down(stride),
    PageUp: up(many),
    PageDown: down(many),
    Home: low,
    End: high,
  })[key];
  return to === undefined ? null : Math.min(Math.max(to, low), high);
};

document.body.addEventListener("keydown", (event) => {
  const { ask, bar } = state;
  const target = /** @type {HTMLElement} */ (event.target);
  if (!ask || !bar || !isOpen() || event.ctrlKey || event.metaKey || event.altKey) return;
  /** @type {Answer | null} */
  let answer = null;
  if (ask.kind === "moment" && target === flag) {
    const from = guess() ?? standing(ask, bar);
    answer = goneTo(event, from, ends(ask, bar), [FEW_TRIALS, MANY_TRIALS]);
  } else if (ask.kind === "sketch" && target.matches(".sketch .knot")) {
    const points = drawn() ?? level(ask, bar);
    const index = Number(target.dataset.index);
    const reward = goneTo(event, points[index][1], bar.rewards, [FEW_REWARD, MUCH_REWARD]);
    if (reward !== null) {
      answer = points.map(([trial, value], at) => [trial, at === index ? reward : value]);
    }
  }
  if (answer === null) return;
  event.preventDefault();
  event.stopPropagation();
  take(answer);
});

const draw = () => {
  const { ask, bar } = state;
  const open = isOpen();
  attribute(document.documentElement, "data-asked", open && ask ? ask.kind : null);
  attribute(document.documentElement, "data-answered", !open && ask ? ask.kind : null);
  // Blocks have keys of their own; what else is not for the answer is not there (guess.css).
  for (const lane of document.querySelectorAll(".time .lanes > *")) lane.toggleAttribute("inert", open);
  // Of a part of the run, what is looked at may be no moment.
  const trial = state.moment?.trial ?? 0;
  const isPart = ask?.kind === "sketch" && bar !== null;
  const isElsewhere = isPart && (trial > bar.axis.end || trial < (bar.axis.start ?? 0));
  document.querySelector(".time")?.toggleAttribute("data-elsewhere", isElsewhere);
  drawAsked(ask, bar, ask && (ask.kind === "moment" ? guess() : drawn()));
};

whenChanged(draw);
