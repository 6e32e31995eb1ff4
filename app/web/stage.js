// @ts-check
// The stage: the board with what is said of it above, and the bar of time below, between viser's
// panels. viser's canvas lies where the stage has its board.

import { whenChanged } from "./changes.js";

const stage = document.createElement("main");
stage.id = "pounce-stage";
stage.innerHTML = `
  <header>
    <p data-slot-of="task"></p>
    <p data-slot-of="sentence"></p>
  </header>
  <div class="board"></div>
  <footer><div data-slot-of="bar"></div></footer>`;
document.body.append(stage);

const part = (/** @type {string} */ name) => /** @type {HTMLElement} */ (stage.querySelector(name));
const board = part(".board");

/** @param {"left" | "right"} side */
const widthOf = (side) =>
  document.querySelector(`[data-dock-region="${side}"]`)?.getBoundingClientRect().width ?? 0;

/** The stage lies between the panels, and the canvas where its board is. */
const place = () => {
  stage.style.left = `${widthOf("left")}px`;
  stage.style.right = `${widthOf("right")}px`;
  const { top, bottom } = board.getBoundingClientRect();
  const root = document.documentElement.style;
  root.setProperty("--board-top", `${top}px`);
  root.setProperty("--board-bottom", `${window.innerHeight - bottom}px`);
};

const watch = new ResizeObserver(place);
for (const node of [stage, board]) watch.observe(node);
/** @type {WeakSet<Element>} */
const watched = new WeakSet();
whenChanged(() => {
  for (const region of document.querySelectorAll("[data-dock-region]"))
    if (!watched.has(region)) {
      watched.add(region);
      watch.observe(region);
    }
  place();
});
