// @ts-check
// The tour: a ring round one thing after the other, with what there is to know of it. Its words come
// from the lab, in the slot `tour`; what was declined is declined for good in this browser.

import { whenChanged } from "./changes.js";
import { region } from "./docks.js";

const SETTING = "pounce-tour";
const GAP_PX = 10;
const FOLLOW_MS = 100;

/** @param {string} selector @returns {Element[]} */
const all = (selector) => [...document.querySelectorAll(selector)];

/** Buttons of the controls by what is written on them. @param {RegExp} name @returns {Element[]} */
const controls = (name) =>
  [...(region("right")?.querySelectorAll("button, [role=tab]") ?? [])].filter(({ textContent }) =>
    name.test(textContent?.trim() ?? ""),
  );

/** Rows of the controls by their labels. @param {RegExp} name @returns {Element[]} */
const fields = (name) =>
  [...(region("right")?.querySelectorAll("label[for]") ?? [])]
    .filter(({ textContent }) => name.test(textContent?.trim() ?? ""))
    .map((label) => label.closest(".mantine-Flex-root") ?? label);

/** Where to find what a stop is about. @type {Record<string, () => Element[]>} */
const THINGS = {
  board: () => all("#pounce-stage .board"),
  sentence: () => all('#pounce-stage [data-slot-of="sentence"], .pounce-legend'),
  play: () => [
    ...controls(/^(Play|Pause)$/),
    ...fields(/steps?\/s$|^Full speed$/),
    ...all("#pounce-stage .play"),
  ],
  bar: () => all('#pounce-stage [data-slot-of="bar"]'),
  skills: () => controls(/^(Add .* now|Experiments)$/),
};

/** @typedef {{at: string, words: Element}} Stop */
/** @type {Stop[]} */
let stops = [];
let here = -1;
/** What had the focus before. @type {HTMLElement | undefined} */
let opener;
/** What has the ring go along, as long as there is one. @type {number | undefined} */
let following;

const card = document.createElement("div");
card.id = "pounce-tour";
card.setAttribute("role", "dialog");
card.innerHTML = `
  <div class="words"></div>
  <div class="ways">
    <span class="count"></span>
    <button type="button" data-tour="back">Back</button>
    <button type="button" data-tour="next">Next</button>
    <button type="button" data-tour="close">Close</button>
  </div>`;
const part = (/** @type {string} */ name) => /** @type {HTMLElement} */ (card.querySelector(name));
const rings = document.createElement("div");
rings.id = "pounce-tour-rings";
rings.setAttribute("aria-hidden", "true");

/** Boxes of what is to be seen of a thing. @param {string} at */
const boxesOf = (at) =>
  (THINGS[at]?.() ?? [])
    .map((thing) => thing.getBoundingClientRect())
    .filter(
      ({ width, height, left, top, right, bottom }) =>
        width > 8 && height > 8 && right > 0 && bottom > 0 && left < innerWidth && top < innerHeight,
    );

/** @param {DOMRect[]} boxes */
const drawRings = (boxes) => {
  while (rings.children.length > boxes.length) rings.lastChild?.remove();
  while (rings.children.length < boxes.length) rings.append(document.createElement("div"));
  boxes.forEach(({ left, top, right, bottom }, index) => {
    const ring = /** @type {HTMLElement} */ (rings.children[index]);
    const edge = 3;
    const [x, y] = [Math.max(left - edge, 0), Math.max(top - edge, 0)];
    ring.style.left = `${x}px`;
    ring.style.top = `${y}px`;
    ring.style.width = `${Math.min(right + edge, innerWidth) - x}px`;
    ring.style.height = `${Math.min(bottom + edge, innerHeight) - y}px`;
  });
};

/** What is drawn of the board. @param {Element | null} board */
const squareOf = (board) => {
  if (!board) return undefined;
  const { left, top, width, height } = board.getBoundingClientRect();
  const size = Math.min(width, height);
  return new DOMRect(left + (width - size) / 2, top + (height - size) / 2, size, size);
};

/** Beside the thing where there is room, and never over the middle of the board. @param {DOMRect} box */
const putCard = (box) => {
  const { width, height } = card.getBoundingClientRect();
  const board = squareOf(document.querySelector("#pounce-stage .board"));
  const most = { x: innerWidth - width - GAP_PX, y: innerHeight - height - GAP_PX };
  const [x, y] = [box.left + (box.width - width) / 2, box.top + (box.height - height) / 2];
  const places = [
    [x, box.bottom + GAP_PX],
    [x, box.top - height - GAP_PX],
    [box.left - width - GAP_PX, y],
    [box.right + GAP_PX, y],
    [GAP_PX, most.y],
    [most.x, most.y],
  ].map(([left, top]) => [
    Math.max(Math.min(left, most.x), GAP_PX),
    Math.max(Math.min(top, most.y), GAP_PX),
  ]);
  /** @param {number} left @param {number} top @param {DOMRect} other @param {number} share */
  const covers = (left, top, other, share) => {
    const [cx, cy] = [other.left + other.width / 2, other.top + other.height / 2];
    const [dx, dy] = [(other.width / 2) * share, (other.height / 2) * share];
    return left < cx + dx && left + width > cx - dx && top < cy + dy && top + height > cy - dy;
  };
  const free = places.find(
    ([left, top]) => !covers(left, top, box, 1) && !(board && covers(left, top, board, 0.6)),
  );
  const beside = places.find(([left, top]) => !(board && covers(left, top, board, 0.6)));
  const [left, top] = free ?? beside ?? places[4];
  card.style.left = `${left}px`;
  card.style.top = `${top}px`;
};

/** The box round those that are near the first one. @param {DOMRect[]} boxes */
const around = ([first, ...others]) => {
  let { left, top, right, bottom } = first;
  for (const box of others)
    if (box.left < right && box.right > left) {
      [left, top] = [Math.min(left, box.left), Math.min(top, box.top)];
      [right, bottom] = [Math.max(right, box.right), Math.max(bottom, box.bottom)];
    }
  return new DOMRect(left, top, right - left, bottom - top);
};

const place = () => {
  if (here < 0) return;
  const boxes = boxesOf(stops[here].at);
  drawRings(boxes);
  if (boxes.length) putCard(around(boxes));
};

const isOpen = () => here >= 0;

const close = () => {
  if (!isOpen()) return;
  here = -1;
  clearInterval(following);
  card.remove();
  rings.remove();
  localStorage.setItem(SETTING, "off");
  settleOffer();
  const isThere = opener?.getClientRects().length;
  const next = isThere ? opener : document.querySelector("#pounce-stage .begin-tour");
  if (next instanceof HTMLElement) next.focus();
};

/**
 * Go on from a stop to the next one that is to be seen.
 * @param {number} from
 * @param {1 | -1} by
 */
const go = (from, by) => {
  let to = from + by;
  while (stops[to] && boxesOf(stops[to].at).length === 0) to += by;
  if (!stops[to]) return by > 0 ? close() : undefined;
  here = to;
  const words = /** @type {Element} */ (stops[to].words.cloneNode(true));
  part(".words").replaceChildren(...words.childNodes);
  card.setAttribute("aria-label", `Tour: ${stops[to].words.querySelector("b")?.textContent}`);
  const shown = stops.filter(({ at }) => boxesOf(at).length > 0);
  part(".count").textContent = `${shown.indexOf(stops[to]) + 1} of ${shown.length}`;
  part("[data-tour=back]").toggleAttribute("disabled", stops[to] === shown[0]);
  part("[data-tour=next]").textContent = stops[to] === shown.at(-1) ? "Done" : "Next";
  place();
  part("[data-tour=next]").focus({ preventScroll: true });
};

const start = () => {
  const { activeElement } = document;
  opener = activeElement instanceof HTMLElement ? activeElement : undefined;
  stops = all('[data-slot-of="tour"] [data-at]').map((words) => ({
    at: words.getAttribute("data-at") ?? "",
    words,
  }));
  document.body.append(rings, card);
  // Nothing tells that something has come to stand elsewhere.
  following = setInterval(place, FOLLOW_MS);
  go(-1, 1);
};

/** @type {Record<string, () => unknown>} */
const ACTS = {
  start: () => isOpen() || start(),
  never: () => {
    localStorage.setItem(SETTING, "off");
    settleOffer();
  },
  back: () => go(here, -1),
  next: () => go(here, 1),
  close,
};

/** Whoever has been offered the tour once is not asked again. */
const settleOffer = () => {
  const isWanted = localStorage.getItem(SETTING) !== "off" && !isOpen();
  for (const offer of all('[data-slot-of="tour"] .offer')) offer.toggleAttribute("hidden", !isWanted);
};

document.addEventListener("click", ({ target }) => {
  const button = target instanceof Element ? target.closest("[data-tour]") : null;
  ACTS[button?.getAttribute("data-tour") ?? ""]?.();
});
card.addEventListener("keydown", (event) => {
  const act = { Escape: close, ArrowRight: ACTS.next, ArrowLeft: ACTS.back }[event.key];
  if (!act) return;
  event.preventDefault();
  // It closes the tour alone, and moves nothing else.
  event.stopPropagation();
  act();
});
addEventListener("resize", place);
addEventListener("scroll", place, true);

/** How often a command has asked for the tour. @type {number | undefined} */
let asked;
whenChanged(() => {
  const times = document.querySelector('[data-slot-of="tour"] [data-times]')?.getAttribute("data-times");
  if (times !== undefined && times !== null) {
    if (asked !== undefined && Number(times) > asked && !isOpen()) start();
    asked = Number(times);
  }
  settleOffer();
  place();
});
