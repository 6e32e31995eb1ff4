// @ts-check
// A term is explained where it stands: on hover, focus and touch, above everything else.
//
// The page draws its texts anew at any time, so nothing is bound to a term itself: a word that was
// drawn anew under the pointer stays explained.

import { whenChanged } from "./changes.js";

const TERM = ".term[data-term]";
const REST_MS = 120;
/** From the edges of the window, and from the term. */
const MARGIN_PX = 6;

/** @type {Record<string, string>} */
let meanings = {};
/** The term that is explained. @type {HTMLElement | undefined} */
let shown;
/** What a touch has opened stays open until the next one. */
let isPinned = false;
/** The term that had the focus last, even if it was taken away with its text. @type {unknown} */
let hadFocus;
const pointer = { x: -1, y: -1 };
let timer = 0;

const tip = document.createElement("div");
tip.id = "pounce-term-tip";
tip.setAttribute("role", "tooltip");
tip.hidden = true;
document.body.append(tip);

/**
 * @param {EventTarget | null} target
 * @returns {HTMLElement | null}
 */
const termOf = (target) => (target instanceof Element ? target.closest(TERM) : null);

const place = () => {
  if (!shown) return;
  const line = [...shown.getClientRects()][0];
  if (!line) return hide();
  const { width, height } = tip.getBoundingClientRect();
  const left = Math.min(line.left, innerWidth - width - MARGIN_PX);
  const below = line.bottom + MARGIN_PX;
  const top = below + height <= innerHeight ? below : line.top - height - MARGIN_PX;
  tip.style.left = `${Math.max(left, MARGIN_PX)}px`;
  tip.style.top = `${Math.max(top, MARGIN_PX)}px`;
};

const hide = () => {
  clearTimeout(timer);
  shown?.removeAttribute("aria-describedby");
  shown = undefined;
  isPinned = false;
  tip.hidden = true;
};

/** @param {HTMLElement} term */
const show = (term) => {
  clearTimeout(timer);
  const key = term.dataset.term ?? "";
  const meaning = meanings[key];
  if (!meaning) return;
  if (shown && shown !== term) shown.removeAttribute("aria-describedby");
  shown = term;
  const name = document.createElement("b");
  name.textContent = key;
  tip.replaceChildren(name, `: ${meaning}`);
  term.setAttribute("aria-describedby", tip.id);
  tip.hidden = false;
  place();
};

const hideSoon = () => {
  clearTimeout(timer);
  timer = setTimeout(hide, REST_MS);
};

document.addEventListener("pointermove", ({ clientX, clientY }) => {
  pointer.x = clientX;
  pointer.y = clientY;
});
document.addEventListener("pointerover", ({ target, pointerType }) => {
  if (pointerType === "touch" || isPinned) return;
  const term = termOf(target);
  if (term) show(term);
  // Whoever reads the explanation may have the pointer over it.
  else if (target === tip) clearTimeout(timer);
  else if (shown && document.activeElement !== shown) hideSoon();
});
document.addEventListener("focusin", ({ target }) => {
  const term = termOf(target);
  hadFocus = term;
  if (term) show(term);
});
document.addEventListener("focusout", ({ target }) => {
  // It leaves a text that is drawn anew as well; then it comes back.
  setTimeout(() => {
    if (target instanceof Node && !target.isConnected) return;
    if (hadFocus === target && document.activeElement !== target) hadFocus = undefined;
    if (target === shown && !isPinned && document.activeElement !== target) hide();
  });
});
document.addEventListener("click", ({ target }) => {
  const term = termOf(target);
  const isOpen = isPinned && term === shown;
  if (!term || isOpen) return hide();
  show(term);
  isPinned = true;
});
addEventListener(
  "keydown",
  (event) => {
    if (event.key !== "Escape" || tip.hidden) return;
    // One press closes one thing.
    event.stopImmediatePropagation();
    hide();
  },
  true,
);
addEventListener("scroll", place, true);
addEventListener("resize", place);

whenChanged(() => {
  const table = document.querySelector("[data-terms]")?.getAttribute("data-terms");
  if (table && Object.keys(meanings).length === 0) meanings = JSON.parse(table);
  if (!shown || shown.isConnected) return;
  // The same word in the text that took the place of the former.
  const key = CSS.escape(shown.dataset.term ?? "");
  const words = [...document.querySelectorAll(`${TERM}[data-term="${key}"]`)];
  const isKept = isPinned || hadFocus === shown;
  // What is under a pointer that rests is known to the page only with its next frame.
  const pointed = termOf(document.elementFromPoint(pointer.x, pointer.y));
  const again = isKept ? words.find((word) => word.getClientRects().length > 0) : pointed;
  if (!(again instanceof HTMLElement)) return hide();
  if (hadFocus === shown) again.focus({ preventScroll: true });
  show(again);
});
