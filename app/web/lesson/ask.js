// @ts-check
// A question: what there is to choose from, how sure one is, and that it is locked once committed.

import { element, write } from "../time/dom.js";
import { choice } from "./choice.js";
import { moment, number } from "./number.js";
import { order } from "./order.js";
import { isPictured } from "./reveal.js";
import { sectors } from "./sectors.js";
import { sketch } from "./sketch.js";
import { answerOf, giveAnswer, setSure, sureOf } from "./state.js";
import { word } from "./words.js";

/**
 * @typedef {import("./state.js").Ask} Ask
 * @typedef {import("./state.js").Answer} Answer
 * @typedef {import("./state.js").Card} Card
 * @typedef {{node: HTMLElement, show: (answer: Answer | null) => void}} Widget
 * @typedef {(ask: Ask, give: (answer: Answer, isDragged?: boolean) => void) => Widget} Maker
 */

/** @type {Record<Ask["kind"], Maker>} */
const MAKERS = { choice, direction: choice, number, moment, sectors, order, sketch };
const SURE = [50, 70, 90];

/** What can be locked as one. */
const fieldset = document.createElement("fieldset");
fieldset.className = "ask";
const legend = element("legend", "unseen");
const place = element("div", "widget");
const confidence = element("fieldset", "confidence");
const locked = element("p", "locked");
fieldset.append(legend, place, confidence);
export const askNode = element("div", "asked");
askNode.append(fieldset, locked);

/** What is there, and of which question. */
let key = "";
/** @type {Widget | null} */
let widget = null;
/** The newest state of the card, which those that were made earlier mean as well. @type {Card | null} */
let current = null;

/** How sure one is: three radio buttons. @param {Card} card */
const makeConfidence = (card) => {
  confidence.replaceChildren(element("legend", "", word("sure")));
  for (const percent of SURE) {
    const label = element("label", "sure");
    const box = document.createElement("input");
    box.type = "radio";
    box.name = "sure";
    box.value = `${percent}`;
    box.addEventListener("change", () => setSure(current ?? card, percent));
    const words = element("span", "");
    words.append(element("b", "", `${percent} %`), element("small", "", word(`sure${percent}`)));
    label.append(box, words);
    confidence.append(label);
  }
};

/** @param {Card | null} card */
export const showAsk = (card) => {
  const ask = card?.ask ?? null;
  // What was expected stands in the picture of what came out, too.
  askNode.hidden = !ask || isPictured(card);
  current = card;
  if (!card || !ask) {
    key = "";
    return;
  }
  const { kind, options, low, high, from, to } = ask;
  const now = JSON.stringify([card.id, kind, options, low, high, from, to, document.documentElement.lang]);
  if (now !== key) {
    key = now;
    widget = MAKERS[kind](ask, (answer, isDragged) => giveAnswer(current ?? card, answer, isDragged));
    place.replaceChildren(widget.node);
    makeConfidence(card);
  }
  write(legend, word(card.kind));
  askNode.classList.toggle("locked-in", ask.locked);
  fieldset.disabled = ask.locked;
  widget?.show(answerOf(card));
  confidence.hidden = !ask.confidence;
  for (const box of confidence.querySelectorAll("input"))
    box.checked = Number(box.value) === sureOf(card);
  write(locked, ask.locked ? word("locked") : "");
};

/** What is still to be done before a question can be committed, in words; "" if nothing is. @param {Card} card */
export const missing = (card) => {
  const { ask } = card;
  if (!ask) return "";
  const answer = answerOf(card);
  // An order is one from the beginning.
  const isThere = ask.kind === "order" || (Array.isArray(answer) ? answer.length > 0 : answer !== null);
  if (!isThere) return word("answerFirst");
  return ask.confidence && sureOf(card) === null ? word("sureFirst") : "";
};
