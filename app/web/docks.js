// @ts-check
// The panels at both sides: which of them are open, and rails that open those that are folded.
//
// In a large window both are open, in a smaller one only the controls, and neither in a small one or
// beside the card of a lesson. There one is open at a time; in a small window it lies over the stage.
// viser would take a panel that it folds out of the page, and with it what the lab tells the stage,
// so folding is done here.

import { whenChanged } from "./changes.js";

/** @typedef {"left" | "right"} Edge */
/** @typedef {"both" | "one" | "beside" | "over"} Room */

export const EDGES = /** @type {const} */ (["left", "right"]);
/** What the panels are called. */
const NAMES = { left: "Your view", right: "The learner" };
const HANDLE = "[data-dock-region-handle]";
const SHEET = ".mantine-ScrollArea-root[data-autosize]";
const NARROW = matchMedia("(max-width: 1199px)");
/** A card has more of the room than one of them. */
const isBesideLesson = () => document.documentElement.dataset.lesson !== undefined;
const SMALL = matchMedia("(max-width: 899px), (max-height: 559px)");

/** Which are open in windows of each kind. @type {Record<Room, Set<Edge>>} */
const open = {
  both: new Set(EDGES),
  one: new Set(["right"]),
  beside: new Set(),
  over: new Set(),
};
/** @type {Array<() => void>} */
const listeners = [];
/** @type {Record<Edge, HTMLElement>} */
const rails = { left: document.createElement("nav"), right: document.createElement("nav") };

/** @returns {Room} */
export const room = () =>
  SMALL.matches ? "over" : isBesideLesson() ? "beside" : NARROW.matches ? "one" : "both";

/** @param {Edge} edge */
export const isOpen = (edge) => open[room()].has(edge);

/** @param {Edge} edge */
export const region = (edge) => document.querySelector(`[data-dock-region="${edge}"]`);

/** @param {Edge} edge */
export const rail = (edge) => rails[edge];

/**
 * Room that a panel takes from the stage: its own if it is open beside it, and else its rail's.
 * @param {Edge} edge
 */
export const taken = (edge) => {
  const { present, side, lesson } = document.documentElement.dataset;
  if (!region(edge) || present !== undefined || (lesson ?? "open") !== "open") return 0;
  // What is there steers the live run, which is not to be seen.
  if (edge === "right" && side !== undefined) return 0;
  const isBeside = isOpen(edge) && room() !== "over";
  return (isBeside ? region(edge) : rail(edge))?.getBoundingClientRect().width ?? 0;
};

/** @param {() => void} listener called when a panel has been opened or folded */
export const whenFolded = (listener) => void listeners.push(listener);

/** Show which of them there are, in a window or beside a lesson that has changed. */
export const showDocks = () => {
  const { dataset } = document.documentElement;
  dataset.room = room();
  dataset.open = EDGES.filter(isOpen).join(" ");
  for (const listener of listeners) listener();
};

/** @param {Edge} edge */
const fold = (edge) => {
  if (open[room()].delete(edge)) showDocks();
};

/** @param {Edge} edge */
const unfold = (edge) => {
  if (room() !== "both") open[room()].clear();
  open[room()].add(edge);
  showDocks();
};

/** @param {Edge} edge @returns {HTMLElement[]} */
const tabsOf = (edge) => [...(region(edge)?.querySelectorAll("[role=tab]") ?? [])].map(
  (tab) => /** @type {HTMLElement} */ (tab),
);

/**
 * Open the panel that has a tab, and turn to it.
 * @param {string} title
 */
export const showTab = (title) => {
  for (const edge of EDGES) {
    const tab = tabsOf(edge).find(({ textContent }) => textContent?.trim() === title);
    if (!tab) continue;
    unfold(edge);
    // viser's own tabs take a press for the beginning of a drag, but obey keys.
    tab.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", bubbles: true }));
    tab.click();
  }
};

/** What has been folded once is a person's to open. @type {WeakSet<Element>} */
const sheets = new WeakSet();

/** On a phone viser has one sheet for all panels, at first open. */
const foldSheet = () => {
  const sheet = document.querySelector(`#root ${SHEET}`);
  const handle = sheet?.querySelector(`${SHEET} .mantine-ScrollArea-content > div > div`);
  if (!sheet || !(handle instanceof HTMLElement) || sheets.has(sheet)) return;
  sheets.add(sheet);
  handle.click();
};

const fillRails = () => {
  for (const edge of EDGES) {
    const titles = tabsOf(edge).map(({ textContent }) => textContent?.trim() ?? "");
    if (rails[edge].dataset.tabs === titles.join()) continue;
    rails[edge].dataset.tabs = titles.join();
    rails[edge].replaceChildren(
      ...["", ...titles].map((title) => {
        const button = document.createElement("button");
        button.type = "button";
        button.textContent = title || (edge === "left" ? "»" : "«");
        if (!title) button.ariaLabel = `Open ${NAMES[edge]}`;
        button.addEventListener("click", () => (title ? showTab(title) : unfold(edge)));
        return button;
      }),
    );
  }
};

for (const edge of EDGES) {
  rails[edge].className = `rail ${edge}`;
  rails[edge].ariaLabel = NAMES[edge];
}
whenChanged(fillRails);
whenChanged(foldSheet);
showDocks();
for (const media of [NARROW, SMALL]) media.addEventListener("change", showDocks);

/** @param {Event} event */
const foldInstead = (event) => {
  const { target } = event;
  const handle = target instanceof Element ? target.closest(HANDLE) : null;
  if (!handle || (event instanceof KeyboardEvent && !["Enter", " "].includes(event.key))) return;
  event.stopImmediatePropagation();
  if (event.type === "pointerdown") return;
  event.preventDefault();
  fold(/** @type {Edge} */ (handle.getAttribute("data-dock-region-handle")));
};
for (const type of ["pointerdown", "click", "keydown"])
  window.addEventListener(type, foldInstead, true);
/** What lies over the stage goes when the stage is wanted. */
export const uncoverStage = () => {
  if (room() === "over") EDGES.forEach(fold);
};
document.addEventListener("pointerdown", ({ target }) => {
  if (target instanceof Element && target.closest("#pounce-stage, canvas")) uncoverStage();
});
