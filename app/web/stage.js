// @ts-check
// The stage: the board, and beside, above or below it what is said of it, between viser's panels.
// viser's canvas lies where the stage has its board.

import { fitCamera, resetView, whenViewChanges } from "./camera.js";
import { whenChanged } from "./changes.js";
import { EDGES, isOpen, rail, region, room, taken, whenFolded } from "./docks.js";
import { onKey, press } from "./keys.js";
import { isInLesson, lessonRoom, whenLessonChanges } from "./lesson.js";
import { placeResults, resultsRoom } from "./results.js";

/** The window in which everything has its first size; in a larger one all grows with it. */
const USUAL = { width: 1366, height: 768 };
const MOST_SCALE = 3;
/** How much larger type is that is to be read from the last row: 13 px become 18. */
const PRESENTED = 1.4;
const LEAST_PRESENTED = 0.9;
/** What stands above, below and beside the board takes about so many pixels at scale 1, less in a lesson. */
const HEAD_PX = 150;
const TAUGHT_HEAD_PX = 40;
const BAR_PX = 220;
const LEGEND_PX = 250;
const TAUGHT_LEGEND_PX = 190;
const TEXT_PX = 190;
const ASIDE_PX = 280;
/** Of a column that has the bar, too, and the least height of one in which that is to be seen. */
const ASIDE_WITH_BAR_PX = 400;
const ALL_PX = 500;
/** What a presentation does without where not all has room, first what most is said without it. */
const SPARED = ["task", "signs", "lines", "forced"];
/** Share of what there is that a board above the bar has to have, where it stands there. */
const LEAST_SHARE = 0.6;
/** Width of a window, in its heights, that has room for a broad column beside a board. */
const BROAD = 1.55;
/** Below this viser has no panels at the sides, but a sheet at the bottom. */
const PHONE = matchMedia("(max-width: 36em)");

const stage = document.createElement("main");
stage.id = "pounce-stage";
stage.innerHTML = `
  <div class="board">
    <div class="over" data-slot-of="said" role="status"></div>
    <button class="reset" type="button" title="Show all of the board again (R)" hidden>Reset view</button>
  </div>
  <div class="aside">
    <header>
      <p data-slot-of="task"></p>
      <div class="tools">
        <button class="learn" type="button" aria-pressed="false" title="Short lessons, beside the board">Learn</button>
        <button class="begin-tour" type="button" data-tour="start" title="Five stops at what one needs first">Tour</button>
        <button class="runs" type="button" data-press="KeyC" title="Two to four runs on boards next to each other (C)">Side by side</button>
        <button class="play" type="button" title="Pause or play (space)">Play</button>
        <button class="present" type="button" aria-pressed="false" title="Only board, sentence, legend, curve and timeline, in large type (P)">Present</button>
      </div>
      <p data-slot-of="sentence"></p>
      <p data-slot-of="experiment"></p>
      <div data-slot-of="opening"></div>
      <div data-slot-of="tour"></div>
    </header>
    <div data-slot-of="readings"></div>
    <div data-slot-of="legend"></div>
    <footer data-slot-of="bar"></footer>
  </div>
  <div class="beside" data-slot-of="side"></div>`;
stage.append(...EDGES.map(rail));
document.body.append(stage);

const part = (/** @type {string} */ name) => /** @type {HTMLElement} */ (stage.querySelector(name));
const board = part(".board");
const present = part(".present");
const reset = part(".reset");
const play = part(".play");
const aside = part(".aside");
const legend = part('[data-slot-of="legend"]');
const bar = part("footer");
const root = document.documentElement;

/** Height of the bar at scale 1 where it is as broad as the stage; it grows with the branches in it. */
let barPx = BAR_PX;

const isPresenting = () => root.dataset.present !== undefined;

/**
 * How the parts stand so that the board is as large as can be. What is said is in a column at its
 * side, or above it, or on a phone below it; the bar is in that column, too, or below the board.
 * @param {number} width
 * @param {number} height
 * @param {number} zoom
 */
const arranged = (width, height, zoom) => {
  if (PHONE.matches) return { shape: "stack", size: Math.min(width, height * 0.45) };
  const isAlone = stage.hasAttribute("data-alone");
  // In a presentation all is to be seen at once, for which the column has to be a broad one; unless the
  // board would have less than half of the height above the bar.
  // In a lesson one points at it, so it is as broad as board and column.
  const holdsBar = isInLesson()
    ? barPx === 0
    : !isPresenting() || width > BROAD * height || barPx * zoom > height / 2;
  const broad = height < ALL_PX * zoom || barPx === 0 ? ASIDE_PX : ASIDE_WITH_BAR_PX;
  const beside = holdsBar ? Math.min(height, width - broad * zoom) : 0;
  // In a lesson neither task nor sentence is there, nor small numbers.
  const [head, legend] = isInLesson() ? [TAUGHT_HEAD_PX, TAUGHT_LEGEND_PX] : [HEAD_PX, LEGEND_PX];
  const said = head + barPx + (isAlone ? legend : 0);
  const between = Math.min(width, height - said * zoom);
  const aside = (isAlone ? ASIDE_PX : TEXT_PX) * zoom;
  const above = Math.min(height - barPx * zoom, width - aside);
  const size = Math.max(beside, between, above, 0);
  if (size < LEAST_SHARE * Math.min(width, height) && !isPresenting())
    // Of a window as small as this the bar takes too much: one scrolls to it.
    return { size: Math.min(height, width - ASIDE_PX * zoom), shape: "side" };
  return { size, shape: size === between ? "column" : size === above ? "corner" : "side" };
};

/** Whether something of the column beside the board is not to be seen, but for a pixel of rounding. */
const isCut = () =>
  [aside, legend].some(({ scrollHeight, clientHeight }) => scrollHeight > clientHeight + 1);

/** By what there was room when something was spared. */
let roomy = "";

/**
 * Nobody scrolls in a presentation, and the bar has to be seen down to its axis. What is spared comes
 * back when the room is another one, and not with each sentence that is shorter: nothing is to jump.
 * @param {string} shape
 */
const spare = (shape) => {
  const key = [shape, innerWidth, innerHeight, bar.offsetHeight, isPresenting()].join(" ");
  if (key !== roomy) stage.dataset.spares = "";
  roomy = key;
  if (!isPresenting() || !["side", "corner"].includes(shape)) return;
  const spared = SPARED.filter((what) => stage.dataset.spares?.includes(what));
  for (const what of SPARED.slice(spared.length)) {
    if (!isCut()) return;
    spared.push(what);
    stage.dataset.spares = spared.join(" ");
  }
};

/** The stage lies between the panels, and the canvas where its board is. */
const place = () => {
  const { innerWidth, innerHeight } = window;
  const larger = Math.min(innerWidth / USUAL.width, innerHeight / USUAL.height);
  const scale = Math.min(Math.max(larger, 1), MOST_SCALE);
  // A browser that shows all larger has made type larger, too.
  const shown = larger < 1 ? Math.min(innerHeight / USUAL.height, 1) : scale;
  const zoom = isPresenting() ? Math.max(shown * PRESENTED, LEAST_PRESENTED) : scale;
  root.style.setProperty("--stage-scale", `${scale}`);
  root.style.setProperty("--stage-zoom", `${zoom}`);
  const beside = resultsRoom();
  const [docked, steers] = EDGES.map(taken);
  const lesson = lessonRoom();
  const right = steers + lesson;
  const left = Math.max(docked, beside);
  root.style.setProperty("--left", `${left}px`);
  root.style.setProperty("--right", `${right}px`);
  root.style.setProperty("--lesson", `${lesson}px`);
  // What the left panel has is not there for all to see when that is folded. Beside results the
  // board has more need of the room.
  const isFolded = !isOpen("left") && !beside;
  const isAlone = isPresenting() || isInLesson() || isFolded || room() === "over";
  stage.toggleAttribute("data-alone", isAlone);
  const { height } = stage.getBoundingClientRect();
  const tall = bar.getBoundingClientRect().height;
  // In a column it is no less high.
  const isBroad = ["column", "corner"].includes(stage.dataset.shape ?? "");
  barPx = Math.max(BAR_PX, isBroad ? tall / zoom : Math.min(barPx, tall / zoom));
  // A lesson may do without it.
  if (!bar.checkVisibility()) barPx = 0;
  const { shape, size } = arranged(innerWidth - left - right, height, zoom);
  stage.dataset.shape = shape;
  root.style.setProperty("--board-size", `${size}px`);
  root.style.setProperty("--bar-height", `${bar.getBoundingClientRect().height}px`);
  spare(shape);
  const place = board.getBoundingClientRect();
  for (const edge of /** @type {const} */ (["left", "top", "width", "height"]))
    root.style.setProperty(`--board-${edge}`, `${place[edge]}px`);
  fitCamera(place.width, place.height);
  placeResults();
};

/** @param {boolean} wanted */
const setPresenting = (wanted) => {
  if (wanted) root.dataset.present = "";
  else delete root.dataset.present;
  present.setAttribute("aria-pressed", `${wanted}`);
  present.textContent = wanted ? "Exit" : "Present";
  place();
};

/** What is looked at plays, which the bar knows; without one it is the live run. */
const sayPlay = () => {
  /** @type {HTMLElement | null} */
  const told = document.querySelector("iframe[data-playing]") ?? document.querySelector("[data-playing]");
  const text = told?.dataset.playing === "yes" ? "Pause" : "Play";
  // What is written anew is a change of the page, after which this is done again.
  if (play.textContent !== text) play.textContent = text;
};

present.addEventListener("click", () => setPresenting(!isPresenting()));
play.addEventListener("click", () => press("Space"));
reset.addEventListener("click", resetView);
onKey("KeyP", () => setPresenting(!isPresenting()));
onKey("KeyR", resetView);
// Escape closes what is open first.
window.addEventListener("keydown", ({ key }) => {
  const over = [...document.querySelectorAll("[role=dialog], [role=listbox]")];
  const isOver = over.some((node) => node.checkVisibility());
  if (key === "Escape" && isPresenting() && !isOver) setPresenting(false);
});
whenViewChanges((isDefault) => (reset.hidden = isDefault));

const watch = new ResizeObserver(place);
for (const node of [root, board, bar]) watch.observe(node);
/** @type {WeakSet<Element>} */
const watched = new WeakSet();
whenFolded(place);
whenLessonChanges(place);
whenChanged(() => {
  for (const dock of EDGES.map(region))
    if (dock && !watched.has(dock)) {
      watched.add(dock);
      watch.observe(dock);
    }
  place();
  sayPlay();
});
document.addEventListener("pounce-playing", sayPlay);
