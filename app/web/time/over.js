// @ts-check
// What lies over the rows: marks, the playhead, what comes after it, A and B, and what happened.

import { shareOf, shareOfStep } from "./axis.js";
import { attribute, element, grouped, keep, percent, write } from "./dom.js";

/**
 * @typedef {import("./state.js").Bar} Bar
 * @typedef {import("./state.js").Happening} Happening
 * @typedef {import("./state.js").Moment} Moment
 * @typedef {import("./state.js").Place} Place
 */

/** What happened nearer together than this is one sign. */
const NEAR_PX = 7;
const MOST_LISTED = 8;
/** A loop shorter than this has its letters beside it. */
const LEAST_LOOP_PX = 34;
/** How often the playhead says where it is to those who do not see it. */
const TOLD_MS = 1000;
/** Room between the playhead's number and those of the axis. */
const APART_PX = 6;

/** Width of the axis in pixels, by which things are moved without anything being laid out anew. */
let wide = 0;
/** How far a thing may reach out to the right of it. */
let beyond = 0;
/** Widths of small things, by what they are and how many characters are on them. @type {Map<string, number>} */
const widths = new Map();

/**
 * @param {number} width
 * @param {number} right what there is to the right of the axis
 */
export const setWidth = (width, right) => {
  beyond = right;
  if (width === wide) return;
  wide = width;
  widths.clear();
};

/**
 * Marks across the rows, each with its name in a box as wide as that may be.
 * @param {HTMLElement} over
 * @param {Bar} bar
 */
export const drawMarks = (over, bar) => {
  over.replaceChildren(
    ...bar.marks.map(({ at, name, more, before, room, hint, note }) => {
      const mark = element("span", `mark ${before ? "before" : "after"}`);
      mark.style[before ? "right" : "left"] = percent(before ? 1 - at : at);
      mark.style.width = percent(room);
      mark.title = hint;
      mark.append(element("i", ""));
      if (note !== null) {
        mark.classList.add("note");
        mark.dataset.note = `${note}`;
      }
      if (name || note !== null) {
        const shown = element("b", "", name);
        if (more) shown.append(element("span", "more", more));
        mark.append(shown);
      }
      return mark;
    }),
  );
};

/**
 * Signs of what happened, to which one can go.
 * @param {HTMLElement} plot
 * @param {Bar} bar
 */
export const drawEvents = (plot, bar) => {
  /** @type {Array<{at: number, of: Happening[]}>} */
  const signs = [];
  for (const happening of bar.happenings) {
    const at = shareOf(bar.axis, happening);
    const last = signs.at(-1);
    if (last && (at - last.at) * wide < NEAR_PX) last.of.push(happening);
    else signs.push({ at, of: [happening] });
  }
  keep(
    plot,
    signs,
    ({ of }) => `${of[0].kind} ${of[0].step}`,
    () => {
      const sign = element("button", "event");
      sign.tabIndex = -1;
      sign.append(element("i", ""));
      return sign;
    },
    (sign, { at, of }) => {
      const texts = of.slice(0, MOST_LISTED).map(({ text }) => text);
      if (of.length > MOST_LISTED) texts.push(`and ${grouped(of.length - MOST_LISTED)} more`);
      sign.style.left = percent(at);
      sign.dataset.kind = of[0].kind;
      sign.dataset.step = `${of[0].step}`;
      attribute(sign, "title", texts.join("\n"));
      attribute(sign, "aria-label", `${texts.join("; ")}: go there`);
    },
  );
};

/**
 * Numbers along the axis.
 * @param {HTMLElement} plot
 * @param {Bar} bar
 */
export const drawTicks = (plot, bar) => {
  const { ticks } = bar.axis;
  plot.replaceChildren(
    ...ticks.map(({ at, text }) => {
      const tick = element("span", "tick", text);
      tick.style.left = percent(at);
      return tick;
    }),
  );
  const last = plot.lastElementChild;
  const between = ticks.length > 1 ? (ticks[1].at - ticks[0].at) * wide : wide;
  // Where not all have room, every second one has.
  plot.classList.toggle(
    "dense",
    last instanceof HTMLElement && last.offsetWidth + APART_PX > between,
  );
};

/**
 * How far it is along the axis, in pixels.
 * @param {number} share
 */
const along = (share) => share * wide;

/**
 * The bracket of a loop, or A alone.
 * @param {HTMLElement} between
 * @param {Bar} bar
 * @param {Moment} moment
 */
const placeLoop = (between, bar, { line, a, loop }) => {
  const first = loop?.a ?? a;
  between.hidden = !first;
  if (!first) return;
  const from = along(shareOf(bar.axis, first));
  const until = loop ? along(shareOf(bar.axis, loop.b)) : from;
  between.classList.toggle("alone", !loop);
  // Of another line, it is told apart from a moment of this one.
  const isHere = !a || a.line === undefined || a.line === line;
  between.classList.toggle("elsewhere", !isHere);
  attribute(between.children[0], "title", isHere ? "A" : "A is a moment of another line");
  between.classList.toggle("narrow", loop !== null && until - from < LEAST_LOOP_PX);
  between.style.width = `${Math.max(until - from, 0)}px`;
  between.style.transform = `translateX(${from}px)`;
};

let toldAt = -Infinity;
let toTell = 0;

/**
 * Tell what does not change with each frame, or those who hear it would hear nothing else.
 * @param {HTMLElement} handle
 * @param {Bar} bar
 * @param {Moment} moment
 */
const tell = (handle, bar, moment) => {
  clearTimeout(toTell);
  const rest = toldAt + TOLD_MS - performance.now();
  if (rest > 0) return void (toTell = setTimeout(() => tell(handle, bar, moment), rest));
  toldAt = performance.now();
  const { trial, live, behind_trials: behind } = moment;
  const past = bar.recorded ? `of ${grouped(bar.end.trial)}` : behindInWords(behind);
  const where = live ? "live" : past;
  attribute(handle, "aria-valuemax", `${Math.max(bar.end.trial, trial)}`);
  attribute(handle, "aria-valuenow", `${trial}`);
  attribute(handle, "aria-valuetext", `trial ${grouped(trial)}, ${where}`);
};

/** @param {number} trials */
const behindInWords = (trials) => {
  const number = grouped(Math.abs(trials));
  const what = Math.abs(trials) === 1 ? "trial" : "trials";
  return `${number} ${what} ${trials < 0 ? "ahead of" : "behind"} the live run`;
};

/**
 * What is written on the playhead.
 * @param {Bar} bar
 * @param {Moment} moment
 */
const written = ({ axis }, { trial, step }) => {
  if (axis.unit === "trials") return grouped(trial);
  const [factor, sign] = axis.end >= 2e5 ? [1e6, "M"] : [1e3, "k"];
  return step ? `${Number((step / factor).toPrecision(3))} ${sign}` : "0";
};

/**
 * Put all that goes with the moment to its place. Nothing is made anew.
 * @param {HTMLElement} time
 * @param {Bar} bar
 * @param {Moment} moment
 * @param {Place} now how far the line is known
 */
export const placeMoment = (time, bar, moment, now) => {
  const part = (/** @type {string} */ name) => /** @type {HTMLElement} */ (time.querySelector(name));
  const share = shareOf(bar.axis, moment);
  const x = along(share);
  const isPast = !moment.live;
  time.classList.toggle("past", isPast);

  part(".playhead").style.transform = `translateX(${x}px)`;
  const end = shareOf(bar.axis, now);
  const veil = part(".veil");
  veil.hidden = !isPast || end <= share;
  veil.style.transform = `translateX(${x}px) scaleX(${Math.max(end - share, 0)})`;

  const handle = part(".handle");
  write(part(".here"), written(bar, moment));
  const edge = wide + beyond;
  const half = widthOf(handle) / 2;
  const far = whereLive(part(".live-end"), bar, isPast, now);
  // Its number is where the moment is, as long as that and what says where the live run is have room.
  const isBefore = far !== null && share <= far.share;
  const limit = edge - half - (isBefore ? 2 * far.half + APART_PX : 0);
  const head = Math.min(x, limit);
  handle.style.transform = `translateX(calc(-50% - ${x - head}px))`;
  const apart = half + APART_PX + (far?.half ?? 0);
  if (far) {
    const wanted = Math.min(along(far.share), edge - far.half);
    far.at = isBefore ? Math.max(wanted, head + apart) : Math.min(wanted, head - apart);
    putLive(part(".live-end"), far);
  }
  tell(handle, bar, moment);
  const spots = [{ x: head, half }, ...(far ? [{ x: far.at, half: far.half }] : [])];
  const ticks = part(".ticks").children;
  bar.axis.ticks.forEach(({ at }, index) => {
    const tick = /** @type {HTMLElement} */ (ticks[index]);
    const least = widthOf(tick) / 2 + APART_PX;
    const isCovered = spots.some((spot) => Math.abs(along(at) - spot.x) < spot.half + least);
    tick.classList.toggle("covered", isCovered);
  });

  const until = part(".until");
  until.hidden = moment.until_step === null;
  if (moment.until_step !== null)
    until.style.transform = `translateX(${along(shareOfStep(bar.axis, moment.until_step))}px)`;
  placeLoop(part(".between"), bar, moment);
};

/**
 * Where the live run is and what says so: half its width, and its middle in pixels.
 * @typedef {{share: number, half: number, at: number}} Far
 */

/**
 * Where the live run is, as long as one looks at something else.
 * @param {HTMLElement} mark
 * @param {Bar} bar
 * @param {boolean} isPast
 * @param {Place} now
 * @returns {Far | null}
 */
const whereLive = (mark, bar, isPast, now) => {
  const live = bar.live ? now : bar.lines.find(({ live }) => live)?.until;
  const place = bar.recorded ? undefined : live;
  mark.hidden = !isPast || !place;
  if (mark.hidden || !place) return null;
  const share = shareOf(bar.axis, place);
  return { share, half: widthOf(/** @type {HTMLElement} */ (mark.firstElementChild)) / 2, at: 0 };
};

/**
 * @param {HTMLElement} mark
 * @param {Far} far
 */
const putLive = (mark, { share, at }) => {
  const place = along(share);
  mark.style.transform = `translateX(${place}px)`;
  const button = /** @type {HTMLElement} */ (mark.firstElementChild);
  button.style.transform = `translateX(calc(-50% + ${at - place}px))`;
};

/**
 * The width of something whose characters are all as wide, measured once for each number of them.
 * @param {HTMLElement} node
 */
const widthOf = (node) => {
  const key = `${node.className} ${node.textContent?.length}`;
  const width = widths.get(key) ?? node.offsetWidth;
  widths.set(key, width);
  return width;
};
