// @ts-check
// A question on the bar and all that is known of its answer, drawn: a flag at a trial, or a curve by six
// points; then this run, and other runs. What a hand does with it stands in guess.js.

import { shareOfTrial, trialAt } from "./axis.js";
import { heightOf } from "./curve.js";
import { attribute, element, keep, percent, write } from "./dom.js";
import "./draw.js";
import { state } from "./state.js";
import { numeralIn, wordOf } from "./words.js";

/** @typedef {import("./state.js").Bar} Bar */
/** @typedef {import("./state.js").Point} Point */
/** @typedef {import("./state.js").MomentAsked} MomentAsked */
/** @typedef {import("./state.js").SketchAsked} SketchAsked */

const SVG = "http://www.w3.org/2000/svg";
/** Units of the picture of curves, as that of the learning curve has them. */
const [WIDE, HIGH] = [1000, 100];

// --- What there is ---------------------------------------------------------------------------------

const rows = /** @type {HTMLElement} */ (document.querySelector(".time > .rows"));
/** Where curves are drawn. */
export const curve = /** @type {HTMLElement} */ (rows.querySelector(".curve > .plot"));

const told = element("p", "asked");
told.setAttribute("role", "status");
told.hidden = true;
/** @type {HTMLElement} */ (rows.parentElement).insertBefore(told, rows);

const over = element("div", "over guess");
over.hidden = true;
over.innerHTML = `
  <div class="beyond"></div><div class="beyond"></div>
  <div class="others"></div>
  <div class="pole run" hidden><i></i><b></b></div>
  <div class="pole mine"><i></i>
    <div class="flag" role="slider" tabindex="0"></div>
  </div>`;
rows.append(over);
const part = (/** @type {string} */ name) => /** @type {HTMLElement} */ (over.querySelector(name));
export const flag = part(".flag");

const sketch = element("div", "sketch");
sketch.hidden = true;
sketch.innerHTML = `<svg viewBox="0 0 ${WIDE} ${HIGH}" preserveAspectRatio="none" aria-hidden="true"></svg>
  <div class="knots" role="group"></div>`;
curve.append(sketch);
const picture = /** @type {SVGElement} */ (sketch.querySelector("svg"));
/** The points of a curve, from left to right. */
export const knots = /** @type {HTMLElement} */ (sketch.querySelector(".knots"));

// --- What is seen ----------------------------------------------------------------------------------

/**
 * The first and the last trial that can be guessed.
 * @param {MomentAsked} ask
 * @param {Bar} bar
 * @returns {[number, number]}
 */
export const ends = (ask, { axis }) => {
  const last = trialAt(axis, 1);
  return [Math.min(ask.from, last), Math.min(ask.to ?? last, last)];
};

/**
 * Where the flag stands before anything was guessed: where the run is, if that can be guessed.
 * @param {MomentAsked} ask
 * @param {Bar} bar
 */
export const standing = (ask, bar) => {
  const [first, last] = ends(ask, bar);
  return Math.min(Math.max(state.moment?.trial ?? bar.end.trial, first), last);
};

/**
 * As long as nothing was drawn the curve goes on as it was last.
 * @param {SketchAsked} ask
 * @param {Bar} bar
 */
export const level = ({ at }, { learned }) => {
  const reward = Math.round(learned.reward.at(-1) ?? 0);
  return at.map((trial) => /** @type {Point} */ ([trial, reward]));
};

/**
 * @param {MomentAsked} ask
 * @param {Bar} bar
 * @param {number | null} at what was guessed
 */
const drawMoment = (ask, bar, at) => {
  const { axis } = bar;
  const isOpen = !ask.locked;
  const pole = part(".pole.mine");
  pole.hidden = at === null && ask.locked;
  pole.classList.toggle("none", at === null);
  placePole(pole, shareOfTrial(axis, at ?? standing(ask, bar)));
  write(flag, at === null ? "?" : wordOf(ask, "yours", at));
  attribute(flag, "aria-label", wordOf(ask, "flag"));
  attribute(flag, "tabindex", isOpen ? "0" : null);
  attribute(flag, "aria-disabled", isOpen ? null : "true");
  const [first, last] = ends(ask, bar);
  attribute(flag, "aria-valuemin", `${first}`);
  attribute(flag, "aria-valuemax", `${last}`);
  attribute(flag, "aria-valuenow", `${at ?? standing(ask, bar)}`);
  attribute(flag, "aria-valuetext", at === null ? wordOf(ask, "noneYet") : wordOf(ask, "trial", at));
  drawBeyond(ask, bar);
  const run = part(".pole.run");
  run.hidden = ask.run === null;
  if (ask.run !== null) {
    placePole(run, shareOfTrial(axis, ask.run));
    write(run.lastElementChild ?? run, wordOf(ask, "runAt", ask.run));
  }
  drawOthers(ask, bar);
  tell(momentWords(ask, at));
};

/**
 * Cover what cannot be guessed, as long as something can.
 * @param {MomentAsked} ask
 * @param {Bar} bar
 */
const drawBeyond = (ask, bar) => {
  const [first, last] = ends(ask, bar).map((trial) => shareOfTrial(bar.axis, trial));
  const [before, after] = /** @type {NodeListOf<HTMLElement>} */ (over.querySelectorAll(".beyond"));
  before.hidden = after.hidden = ask.locked;
  before.style.width = percent(first);
  after.style.left = percent(last);
  after.style.width = percent(1 - last);
};

/**
 * Put a pole to a place, with what is on it to the side that has room.
 * @param {HTMLElement} pole
 * @param {number} share
 */
const placePole = (pole, share) => {
  pole.style.left = percent(share);
  pole.classList.toggle("before", share > 0.5);
};

/**
 * Other runs: a line for each, and a band from the first to the last.
 * @param {MomentAsked} ask
 * @param {Bar} bar
 */
const drawOthers = ({ twenty }, { axis }) => {
  const places = twenty.map((trial) => shareOfTrial(axis, trial)).sort((a, b) => a - b);
  const lines = places.map((share) => {
    const line = element("i", "");
    line.style.left = percent(share);
    return line;
  });
  const band = element("span", "");
  if (places.length) {
    band.style.left = percent(places[0]);
    band.style.width = percent(/** @type {number} */ (places.at(-1)) - places[0]);
    lines.unshift(band);
  }
  part(".others").replaceChildren(...lines);
};

/**
 * @param {MomentAsked} ask
 * @param {number | null} at
 * @returns {Array<[string, string]>}
 */
const momentWords = (ask, at) => {
  const { locked, run, twenty, runs } = ask;
  if (!locked && at === null) return [["", wordOf(ask, "when")]];
  /** @type {Array<[string, string]>} */
  const words = [["mine", at === null ? wordOf(ask, "noGuess") : wordOf(ask, "guess", at)]];
  if (!locked) words.push(["", wordOf(ask, "movable")]);
  if (run !== null) words.push(["run", wordOf(ask, "run", run)]);
  if (twenty.length) {
    const range = [Math.min(...twenty), Math.max(...twenty)];
    const isAll = twenty.length === runs;
    const many = isAll ? [runs] : [twenty.length, runs];
    words.push(["others", wordOf(ask, isAll ? "runs" : "someRuns", ...many, ...range)]);
  }
  return words;
};

/**
 * @param {SketchAsked} ask
 * @param {Bar} bar
 * @param {Point[] | null} answer what was drawn
 */
const drawSketch = (ask, bar, answer) => {
  const { axis, rewards } = bar;
  const up = heightOf(rewards);
  const points = answer ?? (ask.locked ? [] : level(ask, bar));
  const place = (/** @type {number} */ trial, /** @type {number} */ reward) =>
    `${(WIDE * shareOfTrial(axis, trial)).toFixed(1)} ${(HIGH * (1 - up(reward))).toFixed(1)}`;
  const line = (/** @type {Point[]} */ many) => many.map(([trial, reward]) => place(trial, reward)).join("L");
  const { band, run } = ask;
  const edge = band
    ? [
        ...band.at.map((trial, i) => place(trial, band.high[i])),
        ...band.at.map((trial, i) => place(trial, band.low[i])).reverse(),
      ]
    : [];
  /** @type {Array<[string, string]>} */
  const paths = [
    ["others", edge.join("L")],
    ["run", line(run)],
    [`mine${answer ? "" : " none"}`, line(points)],
  ];
  picture.replaceChildren(
    ...paths
      .filter(([, d]) => d)
      .map(([kind, d]) => {
        const path = document.createElementNS(SVG, "path");
        path.setAttribute("class", kind);
        path.setAttribute("d", `M${d}${kind === "others" ? "Z" : ""}`);
        return path;
      }),
  );
  attribute(knots, "aria-label", wordOf(ask, "curve"));
  drawKnots(ask, points, bar);
  tell(sketchWords(ask, answer));
};

/**
 * @param {SketchAsked} ask
 * @param {Point[]} points
 * @param {Bar} bar
 */
const drawKnots = (ask, points, { axis, rewards }) => {
  const isOpen = !ask.locked;
  const up = heightOf(rewards);
  keep(
    knots,
    points.map(([trial, reward], index) => ({ trial, reward, index })),
    ({ index }) => `${index}`,
    ({ index }) => {
      const knot = element("div", "knot");
      knot.dataset.index = `${index}`;
      knot.setAttribute("role", "slider");
      knot.setAttribute("aria-orientation", "vertical");
      knot.append(element("b", ""));
      return knot;
    },
    (knot, { trial, reward }) => {
      knot.style.left = percent(shareOfTrial(axis, trial));
      knot.style.bottom = percent(up(reward));
      attribute(knot, "tabindex", isOpen ? "0" : null);
      attribute(knot, "aria-disabled", isOpen ? null : "true");
      attribute(knot, "aria-label", wordOf(ask, "rewardAt", trial));
      attribute(knot, "aria-valuemin", `${rewards[0]}`);
      attribute(knot, "aria-valuemax", `${rewards[1]}`);
      attribute(knot, "aria-valuenow", `${Math.round(reward)}`);
      attribute(knot, "aria-valuetext", wordOf(ask, "reward", reward));
      write(knot.children[0], numeralIn(ask.language, Math.round(reward)));
    },
  );
};

/**
 * @param {SketchAsked} ask
 * @param {Point[] | null} answer
 * @returns {Array<[string, string]>}
 */
const sketchWords = (ask, answer) => {
  const { from, to, locked, run, band } = ask;
  if (!locked && !answer) return [["", wordOf(ask, "how", from, to)]];
  /** @type {Array<[string, string]>} */
  const words = [["mine", wordOf(ask, answer ? "drawn" : "notDrawn")]];
  if (!locked) words.push(["", wordOf(ask, "changeable")]);
  if (run.length) words.push(["run", wordOf(ask, "thisRun")]);
  if (band) words.push(["others", wordOf(ask, "band")]);
  return words;
};

/**
 * Say how it stands, each thing with its sign.
 * @param {Array<[string, string]>} words
 */
const tell = (words) => {
  const now = JSON.stringify(words);
  if (told.dataset.said === now) return;
  told.dataset.said = now;
  told.replaceChildren(
    ...words.map(([kind, text]) => {
      const item = element("span", `said-of ${kind}`);
      if (kind) item.append(element("i", ""));
      item.append(text);
      return item;
    }),
  );
};

/**
 * Draw what is asked, or nothing.
 * @param {MomentAsked | SketchAsked | null} ask
 * @param {Bar | null} bar
 * @param {number | Point[] | null} answer
 */
export const drawAsked = (ask, bar, answer) => {
  const isThere = ask !== null && bar !== null;
  told.hidden = !isThere;
  over.hidden = !isThere || ask.kind !== "moment";
  sketch.hidden = !isThere || ask.kind !== "sketch";
  if (!isThere) return;
  for (const place of [told, over, sketch]) place.lang = ask.language;
  if (ask.kind === "moment") drawMoment(ask, bar, /** @type {number | null} */ (answer));
  else drawSketch(ask, bar, /** @type {Point[] | null} */ (answer));
};
