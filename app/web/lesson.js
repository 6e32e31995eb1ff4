// @ts-check
// A lesson is a page of its own in a frame, which stands in a column beside the board. While a browser
// is in one, whatever its card does not name is not there: neither to be seen nor to be reached by the
// keyboard, and no key acts. Where all lessons are listed, the panels make room for them.

import { whenChanged } from "./changes.js";
import { showDocks } from "./docks.js";
import { listenTo } from "./frame.js";

/** Of the window, and at least. */
const SHARE = 0.29;
const PRESENTED_SHARE = 0.36;
const LEAST_PX = 300;
/** Without these nobody presents, or finds the board again. */
const ALWAYS = ["KeyP", "KeyR"];
/** How long it may take until somebody is told that it does not come up. */
const PATIENCE_MS = 6_000;
const ABSENT = "Lessons do not come up in this browser.";
/** Below this the card stands under the board, as all else. */
const PHONE = matchMedia("(max-width: 36em)");
const NOW = 'template[data-slot="lesson"]';
const root = document.documentElement;

/** A place for the frame: while it is in the page, the frame is loaded (slots.js). */
const makeSlot = () => {
  const made = document.createElement("section");
  made.className = "lesson";
  made.ariaLabel = "Lesson";
  made.dataset.slotOf = "lesson";
  return made;
};
let slot = makeSlot();
/**
 * What the frame has told: whether this browser is in a lesson, or free of the one that is on; what its
 * card shows and which keys act; and what is asked, as long as it may be answered.
 * @typedef {{where: "in" | "free" | "none", shows: string[], keys: string[], asks: string}} Told
 */
/** @type {Told | null} */
let told = null;
/** Whether somebody has asked for the list here. */
let isWanted = false;
/** Whether the frame has not come up: nobody is locked in by that. */
let isAbsent = false;
let timer = 0;
/** @type {Array<() => void>} */
const listeners = [];
/** @type {WeakSet<Element>} */
const met = new WeakSet();

const frame = () => /** @type {HTMLIFrameElement | null} */ (slot.querySelector("iframe.pounce-lesson"));
const button = () => /** @type {HTMLElement | null} */ (document.querySelector("#pounce-stage .learn"));

/** Whether the lab says that this browser is in a lesson, which the frame knows a moment later. */
const isToldSo = () => {
  const template = /** @type {HTMLTemplateElement | null} */ (document.querySelector(NOW));
  return template?.content.querySelector("[data-lesson-now]") != null;
};

/** In a lesson, beside it with all open, among the list, or none of these. */
const stateNow = () => {
  if (told?.where === "in" || (!told && isToldSo()))
    return isAbsent || told?.shows.includes("all") ? "open" : "card";
  return isWanted && told?.where !== "free" ? "list" : null;
};

export const isInLesson = () => root.dataset.lesson === "card";

/** Room that the card takes from the stage, in pixels. */
export const lessonRoom = () => {
  if (root.dataset.lesson === undefined || PHONE.matches) return 0;
  const share = root.dataset.present === undefined ? SHARE : PRESENTED_SHARE;
  return Math.round(Math.max(innerWidth * share, LEAST_PX));
};

/** @param {() => void} listener called when a lesson, or a card, has other controls, or there is none */
export const whenLessonChanges = (listener) => void listeners.push(listener);

/** @param {string} name @param {string | null | undefined} value */
const mark = (name, value) => {
  if (value === null || value === undefined) delete root.dataset[name];
  else if (root.dataset[name] !== value) root.dataset[name] = value;
};

const show = () => {
  const before = root.dataset.lesson;
  const now = stateNow();
  const { shows = [], keys = [], asks = "" } = told ?? {};
  const isCard = now === "card";
  const isFree = told?.where === "free";
  mark("lesson", now);
  mark("lessonShows", isCard ? shows.join(" ") : null);
  mark("lessonKeys", isCard ? [...ALWAYS, ...keys].join(" ") : null);
  mark("lessonAsks", isCard && asks ? asks : null);
  const isThere = now !== null || isFree;
  if (isThere && !slot.isConnected) document.querySelector("#pounce-stage .aside")?.prepend(slot);
  if (!isThere && slot.isConnected) {
    slot.remove();
    slot = makeSlot();
    told = null;
  }
  const node = button();
  const text = isFree ? "Back to the lesson" : "Learn";
  // What is written anew is a change of the page, after which this is done again.
  if (node && node.textContent !== text) node.textContent = text;
  node?.setAttribute("aria-pressed", `${now !== null}`);
  const place = slot.querySelector(".pounce-no-lesson");
  const absent = isAbsent ? ABSENT : "";
  if (place && place.textContent !== absent) place.textContent = absent;
  if (before === root.dataset.lesson) return;
  showDocks();
  // What had the focus in it is gone.
  if (!now && before) node?.focus();
};

/** The page's height is that of what is in it, where it stands under the board. @param {HTMLIFrameElement} node */
const fit = (node) => {
  const within = node.contentDocument;
  const body = within?.body;
  if (!within || !body) return;
  within.documentElement.toggleAttribute("data-flow", PHONE.matches);
  const height = PHONE.matches ? `${Math.ceil(body.getBoundingClientRect().height)}px` : "";
  if (node.style.height !== height) node.style.height = height;
};

/** Where nothing comes of the frame, that is said, and all is open. @param {HTMLIFrameElement} node */
const watch = (node) => {
  clearTimeout(timer);
  timer = setTimeout(() => {
    isAbsent = node.isConnected && told === null;
    if (isAbsent) changed();
  }, PATIENCE_MS);
};

/** @param {HTMLIFrameElement} node */
const dress = (node) => {
  watch(node);
  const begin = () => {
    const within = /** @type {any} */ (node.contentWindow);
    if (!within || !node.contentDocument?.body) return;
    listenTo(within);
    new within.ResizeObserver(() => fit(node)).observe(node.contentDocument.body);
    PHONE.addEventListener("change", () => fit(node));
    fit(node);
    // A reader of the screen begins there.
    node.focus();
  };
  node.addEventListener("load", begin);
  // Its page may have come before it was met here.
  const page = node.contentDocument;
  if (page?.readyState === "complete" && page.URL !== "about:blank") begin();
};

const changed = () => {
  show();
  for (const listener of listeners) listener();
};

document.addEventListener("pounce-lesson", (event) => {
  told = /** @type {CustomEvent<Told>} */ (event).detail;
  isAbsent = false;
  // Who has finished one sees the list, also where the page came up in it.
  if (told?.where === "in") isWanted = true;
  changed();
});
document.addEventListener("pounce-lesson-close", () => {
  isWanted = false;
  changed();
});
document.addEventListener("click", ({ target }) => {
  if (!(target instanceof Element) || !target.closest("#pounce-stage .learn")) return;
  const within = /** @type {any} */ (frame()?.contentWindow);
  if (told?.where === "free")
    within?.dispatchEvent(new within.CustomEvent("pounce-learn"));
  else {
    isWanted = !isWanted;
    changed();
  }
});
whenChanged(() => {
  show();
  const node = frame();
  if (!node) return;
  // What the lab sends anew takes away what was done to the frame here.
  if (PHONE.matches) fit(node);
  if (met.has(node)) return;
  met.add(node);
  dress(node);
});
