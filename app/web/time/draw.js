// @ts-check
// Draws the time bar from the state: what a new bar has is drawn anew, and a moment only moves things.

import { drawCurve } from "./curve.js";
import { attribute, element, keep, write } from "./dom.js";
import { drawBands, drawLanes, markLanes } from "./lanes.js";
import { drawEvents, drawMarks, drawTicks, placeMoment, setWidth } from "./over.js";
import { drawRule, markRule, ruleHtml } from "./rule.js";
import { state, whenChanged } from "./state.js";
import { drawTree, markTree } from "./tree.js";

/**
 * @typedef {import("./state.js").Bar} Bar
 * @typedef {import("./state.js").Moment} Moment
 */

const time = element("div", "time");
time.setAttribute("role", "group");
time.setAttribute("aria-label", "Time: learning curve and schedule");
time.innerHTML = `
  <div class="legend"></div>
  <div class="rows">
    <div class="over bands"></div>
    <div class="row curve">
      <div class="gutter"><span class="what">reward<br />per trial</span><span class="numbers"></span></div>
      <div class="plot"><svg viewBox="0 0 1000 100" preserveAspectRatio="none" role="img" aria-label="Learning curve: reward per trial"></svg></div>
    </div>
    ${ruleHtml}
    <div class="tree" role="group" aria-label="Lines of this session" hidden></div>
    <div class="lanes"></div>
    <div class="row axis">
      <div class="gutter units" role="group" aria-label="What the axis is of"></div>
      <div class="plot"><div class="ticks"></div><div class="events" role="group" aria-label="What happened"></div></div>
    </div>
    <div class="over marks"></div>
    <div class="over moving">
      <div class="meets" hidden></div>
      <div class="veil" hidden></div>
      <div class="until" hidden><i title="The run stands still here"></i></div>
      <div class="between" hidden><b>A</b><b>B</b></div>
      <div class="live-end" hidden><button type="button" title="Look at what happens now (End)">Live</button></div>
      <div class="playhead"><i></i>
        <div class="handle" role="slider" tabindex="0" aria-label="Moment that is shown" aria-valuemin="0"><span class="here"></span></div>
      </div>
    </div>
  </div>`;

const part = (/** @type {string} */ name) => /** @type {HTMLElement} */ (time.querySelector(name));
const axis = part(".axis > .plot");

/** Where the axis lies in the page, from its beginning to its end. */
export const plotBox = () => axis.getBoundingClientRect();

/**
 * The share of the axis at which a pointer is, below 0 or above 1 beside it.
 * @param {{clientX: number}} event
 */
export const shareAt = ({ clientX }) => {
  const { left, width } = plotBox();
  return (clientX - left) / width;
};

/** What was drawn last. @type {Array<unknown>} */
let drawn = [];
let wide = 0;

/** @param {Bar} bar */
const drawBar = (bar) => {
  const { draft } = state;
  const [formerBar, formerDraft, formerWide] = drawn;
  const isNew = bar !== formerBar;
  const isWider = wide !== formerWide;
  drawn = [bar, draft, wide];
  if (isNew) {
    time.style.setProperty("--lanes", `${bar.lanes.length}`);
    drawLegend(bar);
    drawUnits(bar);
    drawCurve(part(".curve"), bar);
    drawRule(part(".rule"), bar);
    drawMarks(part(".marks"), bar);
    for (const [scheme, colours] of Object.entries(bar.colours))
      for (const [role, colour] of Object.entries(colours))
        time.style.setProperty(`--${scheme}-${role}`, colour);
  }
  if (isNew || isWider) {
    drawTree(part(".tree"), bar, wide);
    drawEvents(part(".events"), bar);
    drawTicks(part(".ticks"), bar);
  }
  if (isNew || draft !== formerDraft) {
    time.classList.toggle("drafting", draft !== null);
    drawLanes(part(".lanes"), bar, draft);
    drawBands(part(".bands"), bar, draft);
  }
  return isNew;
};

/** What has a meaning of its own beside the curves: it is explained to the keyboard, too. */
const TERMS = ["forced", "taught", "frozen"];

/** @param {Bar} bar */
const drawLegend = (bar) =>
  keep(
    part(".legend"),
    bar.legend,
    ({ kind }) => kind,
    ({ kind }) => {
      const item = element("span", `item ${kind}`);
      item.append(element("i", ""), element("span", ""));
      if (TERMS.includes(kind)) {
        item.tabIndex = 0;
        item.setAttribute("role", "term");
      }
      return item;
    },
    (item, { text, hint }, place) => {
      item.style.order = `${place}`;
      write(item.children[1], text);
      attribute(item, "title", hint || null);
    },
  );

/** @param {Bar} bar */
const drawUnits = (bar) => {
  const units = part(".units");
  bar.units.forEach(({ unit, name, hint }, index) => {
    const button = units.children[index] ?? units.appendChild(element("button", "unit"));
    write(button, name);
    attribute(button, "data-unit", unit);
    attribute(button, "title", hint);
    attribute(button, "aria-pressed", `${unit === bar.axis.unit}`);
  });
};

const draw = () => {
  const { bar, moment, scrub } = state;
  time.hidden = !bar;
  if (!bar) return;
  const isNew = drawBar(bar);
  if (isNew) measure();
  const told = moment ?? atEnd(bar);
  // A bar comes less often than moments: what runs has come as far as the newest of them.
  const now = told.live && told.line === bar.line ? told : bar.end;
  const seen = scrub ? held(told, scrub) : told;
  markLanes(bar, now, seen);
  markRule(part(".rule"), part(".meets"), bar, seen);
  markTree(part(".tree"), seen.line);
  placeMoment(time, bar, seen, now);
};

/**
 * What is shown as long as nobody has said what is looked at.
 * @param {Bar} bar
 * @returns {Moment}
 */
const atEnd = ({ line, live, end }) => ({
  ...{ line, live, ...end, behind_trials: 0, behind_steps: 0, playing: false, direction: 1 },
  ...{ rate: 1, rates: [], a: null, loop: null, holds: false, stops: false, until_step: null },
  watched: null,
});

/**
 * The moment at which a hand holds the playhead: what the lab shows follows it.
 * @param {Moment} told
 * @param {import("./state.js").Place} place
 * @returns {Moment}
 */
const held = (told, { trial, step }) => {
  const behind_trials = told.trial + told.behind_trials - trial;
  return { ...told, trial, step, live: false, behind_trials };
};

/** Widths are measured when they change, and not with each frame. */
const measure = () => {
  const box = axis.getBoundingClientRect();
  wide = box.width;
  setWidth(wide, Math.max(time.getBoundingClientRect().right - box.right, 0));
};

document.body.append(time);
new ResizeObserver(() => {
  measure();
  draw();
}).observe(axis);
whenChanged(draw);
