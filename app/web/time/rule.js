// @ts-check
// What a rule watches, under the learning curve: how it goes, its threshold, and when it would be met.

import { shareOfTrial, trialAt } from "./axis.js";
import { attribute, element, grouped, percent, write } from "./dom.js";

/**
 * @typedef {import("./state.js").Bar} Bar
 * @typedef {import("./state.js").Moment} Moment
 * @typedef {import("./state.js").Rule} Rule
 */

const WIDE = 1000;
const HIGH = 100;
const SVG = "http://www.w3.org/2000/svg";
/** Of the line that says how it would go on: straight, and so bent on a scale of logarithms. */
const PIECES = 16;

/** The row of what rules watch, and the line from it to the lane of the skill that would join. */
export const ruleHtml = `
  <div class="row rule" hidden>
    <div class="gutter"><span class="what"></span><span class="numbers"><span></span></span></div>
    <p class="asks"><span class="long"></span><span class="short"><span class="more"></span><span></span></span><span class="now"></span></p>
    <div class="plot">
      <div class="course"><svg viewBox="0 0 ${WIDE} ${HIGH}" preserveAspectRatio="none" role="img"></svg></div>
    </div>
  </div>`;

/** What is said by now. @type {{of: Rule | null, at: string}} */
let drawn = { of: null, at: "" };

/**
 * How high a number is, as a share.
 * @param {Rule} rule
 * @param {number} value
 */
const heightOf = ({ ends: [low, high] }, value) =>
  Math.min(Math.max(Math.log(Math.max(value, low) / low) / Math.log(high / low), 0), 1);

/** @param {Rule} rule @param {number} value */
const y = (rule, value) => (HIGH * (1 - heightOf(rule, value))).toFixed(1);

/** @param {string} kind @param {string} d */
const pathOf = (kind, d) => {
  const path = document.createElementNS(SVG, "path");
  path.setAttribute("class", kind);
  path.setAttribute("d", d);
  return path;
};

/**
 * Draw what goes by the bar alone.
 * @param {HTMLElement} row
 * @param {Bar} bar
 */
export const drawRule = (row, bar) => {
  row.hidden = !bar.rules.length;
  drawn = { of: null, at: "" };
  const at = (/** @type {number} */ trial) => (WIDE * shareOfTrial(bar.axis, trial)).toFixed(1);
  const paths = bar.rules.flatMap((rule) => {
    const points = rule.trials.map((trial, i) => `${at(trial)} ${y(rule, rule.values[i])}`);
    const end = rule.until === null ? WIDE : at(rule.until);
    const line = y(rule, rule.below);
    const met = rule.met ? [pathOf("met", `M${points.at(-1)}h0`)] : [];
    return [
      pathOf("threshold", `M${at(rule.first)} ${line}H${end}`),
      ...(points.length ? [pathOf("watched", `M${points.join("L")}`)] : []),
      ...met,
    ];
  });
  row.querySelector("svg")?.replaceChildren(...paths, pathOf("outlook", ""));
};

/**
 * Whether it is over at a moment. One that was met lets its skill join at the start of a trial, of which
 * one sees the moment before, too.
 * @param {Rule} rule
 * @param {Moment} seen
 */
const isOver = ({ until, met }, { trial }) => until !== null && (met ? trial > until : trial >= until);

/**
 * The one that is waited for at a moment, or the last that was.
 * @param {Rule[]} rules
 * @param {Moment} seen
 */
const awaited = (rules, seen) =>
  rules.find((rule) => !isOver(rule, seen)) ?? rules[rules.length - 1];

/**
 * What is known of it at a moment: of what the bar has the newest, unless the moment itself has more.
 * @param {Rule} rule
 * @param {Moment} seen
 * @returns {{value: number, fires: number} | null}
 */
const knownOf = ({ trials, values, fires }, { trial, watched }) => {
  let last = trials.length - 1;
  while (last >= 0 && trials[last] > trial) last -= 1;
  if (watched && watched.trial <= trial && watched.trial >= (trials[last] ?? 0)) return watched;
  return last < 0 ? null : { value: values[last], fires: fires[last] };
};

/**
 * What it is at a moment, and what would come of it.
 * @param {Rule} rule
 * @param {Moment} seen
 * @param {{value: number, fires: number} | null} known
 * @param {boolean} isNow
 */
const saidOf = (rule, seen, known, isNow) => {
  if (isOver(rule, seen)) return rule.met ? `: so it did at trial ${grouped(rule.until ?? 0)}` : "";
  if (!known) return `: known from trial ${grouped(rule.known)} on`;
  const [when, that] = isNow ? ["now", "this"] : ["then", "that"];
  const outlook = known.fires < 0 ? "not falling" : `at ${that} rate at trial ${grouped(known.fires)}`;
  return `: ${Number(known.value.toPrecision(2))} ${when}; ${outlook}`;
};

/**
 * Say what goes by the moment that is looked at.
 * @param {HTMLElement} row
 * @param {HTMLElement} meets the line from the row to the lane
 * @param {Bar} bar
 * @param {Moment} seen
 */
export const markRule = (row, meets, bar, seen) => {
  if (!bar.rules.length) return void (meets.hidden = true);
  const rule = awaited(bar.rules, seen);
  const known = knownOf(rule, seen);
  const said = saidOf(rule, seen, known, seen.live || bar.recorded);
  const at = `${said} ${seen.step}`;
  if (drawn.at === at && drawn.of === rule) return;
  if (drawn.of !== rule) nameIt(row, rule);
  drawn = { of: rule, at };
  write(/** @type {HTMLElement} */ (row.querySelector(".now")), said);
  const about = `${rule.long}${said}`;
  attribute(row, "title", about);
  attribute(/** @type {SVGElement} */ (row.querySelector("svg")), "aria-label", about);
  const ahead = known && !isOver(rule, seen) && known.fires > seen.trial ? known : null;
  row.querySelector(".outlook")?.setAttribute("d", ahead ? outlookOf(rule, bar, seen, ahead) : "");
  meets.hidden = !ahead || ahead.fires > trialAt(bar.axis, 1);
  if (ahead && !meets.hidden) placeMeeting(row, meets, bar, rule, ahead.fires);
};

/**
 * What it is of, beside its numbers.
 * @param {HTMLElement} row
 * @param {Rule} rule
 */
const nameIt = (row, rule) => {
  const part = (/** @type {string} */ name) => /** @type {HTMLElement} */ (row.querySelector(name));
  const [what, per] = rule.what;
  part(".what").replaceChildren(what, document.createElement("br"), per);
  write(part(".long"), rule.long);
  const [who, asks] = rule.short;
  write(part(".short > .more"), `${who} `);
  write(part(".short > :last-child"), asks);
  const number = part(".numbers > span");
  write(number, `${rule.below}`);
  number.style.bottom = percent(heightOf(rule, rule.below));
};

/**
 * How it would go on.
 * @param {Rule} rule
 * @param {Bar} bar
 * @param {Moment} seen
 * @param {{value: number, fires: number}} known
 */
const outlookOf = (rule, { axis }, { trial }, { value, fires }) => {
  const points = [];
  for (let piece = 0; piece <= PIECES; piece += 1) {
    const share = piece / PIECES;
    const then = trial + share * (fires - trial);
    if (then > trialAt(axis, 1)) break;
    const falls = value + share * (rule.below - value);
    points.push(`${(WIDE * shareOfTrial(axis, then)).toFixed(1)} ${y(rule, falls)}`);
  }
  return points.length > 1 ? `M${points.join("L")}` : "";
};

/**
 * Where the skill would join, from what is watched down to its lane.
 * @param {HTMLElement} row
 * @param {HTMLElement} meets
 * @param {Bar} bar
 * @param {Rule} rule
 * @param {number} fires
 */
const placeMeeting = (row, meets, bar, rule, fires) => {
  const lanes = /** @type {Iterable<HTMLElement>} */ (document.querySelectorAll(".time .lane"));
  const lane = [...lanes].find(({ dataset }) => dataset.skill === rule.skill);
  if (!lane) return void (meets.hidden = true);
  const top = row.getBoundingClientRect();
  const over = /** @type {HTMLElement} */ (meets.parentElement).getBoundingClientRect();
  const line = top.bottom - heightOf(rule, rule.below) * (row.querySelector("svg")?.clientHeight ?? 0);
  meets.style.top = `${line - over.top}px`;
  meets.style.height = `${lane.getBoundingClientRect().bottom - line}px`;
  meets.style.left = percent(shareOfTrial(bar.axis, fires));
};
