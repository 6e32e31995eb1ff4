// @ts-check
// Whether what a card asks for has come true, what to do where it no longer can, and hints.

import { put } from "../player/html.js";
import { send } from "../player/pipe.js";
import { element, write } from "../time/dom.js";
import { word } from "./words.js";

/** @typedef {import("./state.js").Card} Card */

export const checkNode = element("section", "check");
checkNode.innerHTML = `
  <p class="verdict" role="status"></p>
  <ol class="hints" aria-live="polite"></ol>
  <button type="button" class="hint quiet"></button>`;
const part = (/** @type {string} */ name) => /** @type {HTMLElement} */ (checkNode.querySelector(name));

part(".hint").addEventListener("click", () => send({ do: "hint" }));

/** @param {Card | null} card */
export const showCheck = (card) => {
  const check = card?.check ?? null;
  const { hints = [], next_hint = null } = card ?? {};
  checkNode.hidden = !check && !hints.length && !next_hint;
  const verdict = part(".verdict");
  verdict.dataset.verdict = check?.verdict ?? "";
  verdict.hidden = !check;
  put(verdict, check ? check.html || (check.verdict === "yes" ? word("yes") : "") : "");
  const list = part(".hints");
  list.ariaLabel = word("hints");
  list.hidden = hints.length === 0;
  while (list.children.length > hints.length) list.lastChild?.remove();
  hints.forEach((html, at) => put(list.children[at] ?? list.appendChild(document.createElement("li")), html));
  const more = part(".hint");
  more.hidden = !next_hint || (check !== null && check.verdict !== "not yet");
  write(more, word(next_hint === "does" ? "doIt" : "hint"));
};
