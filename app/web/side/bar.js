// @ts-check
// The one bar: curves of all runs along steps, and the playhead, which all boards go by.

import { roundest, shareOfStep, stepAt } from "../time/axis.js";
import { attribute, element, grouped, keep, percent, reach, write } from "../time/dom.js";
import { heightOf } from "../time/curve.js";
import { send, sendNewest } from "../player/pipe.js";
import { changed, state, whenChanged } from "./state.js";
import { dressLine } from "./swatch.js";

const SVG = "http://www.w3.org/2000/svg";
const WIDE = 1000;
const HIGH = 100;
/** So long the playhead waits where a hand has let it go, unless it is shown there before. */
const PATIENCE_MS = 1_500;
/** Arrows go by so many of what lies between two numbers of the axis. */
const ARROW_SHARE = 0.01;
const PAGE_SHARE = 0.1;

const bar = element("section", "bar");
bar.setAttribute("aria-label", "Learning curves of all runs, by steps");
bar.innerHTML = `
  <p class="what">reward per trial</p>
  <div class="gutter numbers"></div>
  <div class="plot">
    <svg class="curves" viewBox="0 0 ${WIDE} ${HIGH}" preserveAspectRatio="none" role="img"></svg>
    <div class="ahead"></div>
    <div class="playhead"><i></i><div class="handle" role="slider" tabindex="0" aria-label="Step that is shown" aria-valuemin="0"><span></span></div></div>
  </div>
  <div class="gutter unit">steps</div>
  <div class="axis"><div class="ticks"></div><div class="events" role="group" aria-label="What happened"></div></div>`;
document.body.append(bar);

const part = (/** @type {string} */ name) => /** @type {HTMLElement} */ (bar.querySelector(name));
const plot = part(".plot");
const head = part(".playhead");
const handle = part(".handle");
const ahead = part(".ahead");

// --- Drawing ---------------------------------------------------------------------------------------

/** @param {string} kind @param {string} d */
const path = (kind, d) => {
  const made = document.createElementNS(SVG, "path");
  made.setAttribute("class", kind);
  made.setAttribute("d", d);
  return made;
};

/** @type {unknown[]} */
let drawn = [];

const drawCurves = () => {
  const { curves, race } = state;
  if (drawn[0] === curves && drawn[1] === race) return;
  drawn = [curves, race];
  if (!curves || !race) return;
  const up = heightOf(curves.rewards);
  const y = (/** @type {number} */ reward) => (HIGH * (1 - up(reward))).toFixed(1);
  const levels = curves.levels.map(([reward]) =>
    path(reward === 0 ? "zero" : "level", `M0 ${y(reward)}H${WIDE}`),
  );
  const lines = curves.curves.map(({ at, reward }, index) => {
    const points = at.map((x, i) => `${(WIDE * x).toFixed(1)} ${y(reward[i])}`);
    const line = path("run-line", points.length ? `M${points.join("L")}` : "");
    const run = race.runs[index];
    if (run) dressLine(line, run.look);
    return line;
  });
  part(".curves").replaceChildren(...levels, ...lines);
  part(".curves").setAttribute(
    "aria-label",
    `Learning curves of ${race.runs.map(({ name }) => name).join(", ")}`,
  );
  keep(
    part(".numbers"),
    curves.levels,
    ([reward]) => `${reward}`,
    ([, text]) => element("span", "", text),
    (number, [reward, text]) => {
      number.style.bottom = percent(up(reward));
      write(number, text);
    },
  );
  keep(
    part(".ticks"),
    curves.axis.ticks,
    ({ text }) => text,
    ({ text }) => element("span", "tick", text),
    (tick, { at }) => {
      tick.style.left = percent(at);
      tick.toggleAttribute("data-last", at > 0.95);
    },
  );
  keep(
    part(".events"),
    curves.events,
    ({ step, run, text }) => `${step} ${run} ${text}`,
    ({ kind }) => {
      const button = element("button", "event");
      button.setAttribute("type", "button");
      button.dataset.kind = kind;
      button.append(element("i", ""));
      return button;
    },
    (button, { step, run, text }) => {
      button.style.left = percent(shareOfStep(curves.axis, step));
      button.style.setProperty("--on-light", race.runs[run]?.look.light ?? "");
      button.style.setProperty("--on-dark", race.runs[run]?.look.dark ?? "");
      const said = `${race.runs[run]?.name}, step ${grouped(step)}: ${text}`;
      button.dataset.step = `${step}`;
      attribute(button, "title", said);
      attribute(button, "aria-label", said);
    },
  );
};

const drawMoment = () => {
  const { curves, moment } = state;
  head.hidden = !curves || !moment;
  if (!curves || !moment) return;
  const step = state.scrub ?? moment.step;
  const share = shareOfStep(curves.axis, step);
  head.style.left = percent(share);
  reach(ahead, share, moment.live ? share : 1);
  bar.toggleAttribute("data-live", moment.live && state.scrub === null);
  head.toggleAttribute("data-far", share > 0.7);
  const text = `step ${grouped(step)}`;
  write(/** @type {Element} */ (handle.firstElementChild), text);
  attribute(handle, "aria-valuemax", `${moment.end}`);
  attribute(handle, "aria-valuenow", `${step}`);
  attribute(handle, "aria-valuetext", moment.live ? `${text}, now` : text);
};

whenChanged(() => {
  if (timer && state.moment && isThere()) put(null);
  drawCurves();
  drawMoment();
});

// --- The playhead in a hand ------------------------------------------------------------------------

let timer = 0;
/** The step that was asked for last; null for now. @type {number | null} */
let wished = null;
let isHeld = false;

const isThere = () =>
  wished === null ? state.moment?.live === true : state.moment?.step === wished;

/** @param {number | null} step */
const put = (step) => {
  clearTimeout(timer);
  timer = 0;
  state.scrub = step;
  changed();
};

/** @param {number} clientX */
const look = (clientX) => {
  const { curves, moment } = state;
  if (!curves || !moment) return;
  const { left, width } = plot.getBoundingClientRect();
  const pointed = stepAt(curves.axis, (clientX - left) / width);
  const step = roundest(pointed, curves.axis.end / (width || 1));
  const isBeyond = step >= moment.end;
  wished = isBeyond ? null : step;
  put(isBeyond ? moment.end : step);
  sendNewest(isBeyond ? { do: "live" } : { do: "seek", step });
};

const letGo = () => {
  if (!isHeld) return;
  isHeld = false;
  timer = setTimeout(() => put(null), PATIENCE_MS);
  changed();
};

for (const node of [plot, part(".axis")])
  node.addEventListener("pointerdown", (event) => {
    if (event.button || /** @type {Element} */ (event.target).closest(".event")) return;
    event.preventDefault();
    isHeld = true;
    node.setPointerCapture(event.pointerId);
    handle.focus({ preventScroll: true });
    look(event.clientX);
  });
for (const node of [plot, part(".axis")]) {
  node.addEventListener("pointermove", ({ clientX }) => {
    if (isHeld) look(clientX);
  });
  for (const kind of ["pointerup", "pointercancel", "lostpointercapture"])
    node.addEventListener(kind, letGo);
}

/** @param {number} share of what is known of the axis @param {1 | -1} way */
const goBy = (share, way) => {
  const { curves, moment } = state;
  if (!curves || !moment) return;
  const unit = roundest(curves.axis.end * share, Math.max(curves.axis.end * share * 0.5, 1)) || 1;
  const from = state.scrub ?? moment.step;
  const step = Math.max((way > 0 ? Math.floor(from / unit) + 1 : Math.ceil(from / unit) - 1) * unit, 0);
  const isBeyond = step >= moment.end;
  wished = isBeyond ? null : step;
  put(isBeyond ? moment.end : step);
  timer = setTimeout(() => put(null), PATIENCE_MS);
  send(isBeyond ? { do: "live" } : { do: "seek", step });
};

handle.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const share = event.shiftKey ? PAGE_SHARE : ARROW_SHARE;
  const act = /** @type {Record<string, () => unknown>} */ ({
    ArrowLeft: () => goBy(share, -1),
    ArrowDown: () => goBy(share, -1),
    ArrowRight: () => goBy(share, 1),
    ArrowUp: () => goBy(share, 1),
    PageDown: () => goBy(PAGE_SHARE, -1),
    PageUp: () => goBy(PAGE_SHARE, 1),
  })[event.key];
  if (!act) return;
  event.preventDefault();
  event.stopPropagation();
  act();
});

part(".events").addEventListener("click", ({ target }) => {
  const event = /** @type {HTMLElement | null} */ (/** @type {Element} */ (target).closest(".event"));
  if (event) send({ do: "seek", step: Number(event.dataset.step) });
});
