// @ts-check
// What is said of what a hand did lies over the bar for a while, so that nothing moves for it, and until it
// is closed if that can be undone; what a branch does otherwise stays where the legend is.

import { on } from "../player/pipe.js";

const LASTS_MS = 8_000;

const over = document.createElement("div");
over.className = "told";
over.innerHTML = `
  <p class="note" role="status"><span></span><button type="button" aria-label="Close" hidden>×</button></p>
  <p class="said" role="status"><span></span><button type="button" class="act" hidden></button
    ><button type="button" aria-label="Close" hidden>×</button></p>`;

/** @param {string} kind */
const part = (kind) => /** @type {HTMLElement} */ (over.querySelector(`.${kind}`));

let timer = 0;
/** What can be done about what is said. @type {Undo | undefined} */
let offered;
/** @typedef {{label: string, act: () => void}} Undo */

/**
 * @param {string} kind
 * @param {string} text
 */
const put = (kind, text) => {
  const place = part(kind);
  // What is said is heard where the place for it has been there before.
  /** @type {HTMLElement} */ (place.firstElementChild).textContent = text;
  /** @type {HTMLElement} */ (place.lastElementChild).hidden = !text;
  place.toggleAttribute("data-told", text !== "");
};

/**
 * Say something for a while, or until it is closed if something can be done about it.
 * @param {string} text
 * @param {Undo} [undo] what can be done about it
 */
export const say = (text, undo) => {
  clearTimeout(timer);
  put("said", text);
  const button = part("act");
  button.hidden = !undo;
  button.textContent = undo?.label ?? "";
  offered = undo;
  if (text && !undo) timer = setTimeout(() => say(""), LASTS_MS);
};

over.addEventListener("click", ({ target }) => {
  const button = /** @type {Element} */ (target).closest("button");
  if (!button) return;
  if (button.classList.contains("act")) offered?.act();
  if (button.closest(".note")) put("note", "");
  else say("");
});

/** @type {Array<() => void>} */
const works = [];

/**
 * Do something when the lab says that something was not done.
 * @param {() => void} work
 */
export const whenRefused = (work) => void works.push(work);

on("said", ({ text, refused }) => {
  if (refused) for (const work of works) work();
  if (refused || !offered) return say(text);
  // What follows of something does not take away that it can be undone.
  const former = part("said").firstElementChild?.textContent;
  say(`${former} ${text}`, offered);
});
on("note", ({ text }) => put("note", text));
// Below the row of buttons, which comes first, however high that is.
document.body.prepend(over);
