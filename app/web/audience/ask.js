// @ts-check
// A class's part of the page: the presenter's card of a lesson, what is asked, one's own answer, and
// what all have answered once that is shown.

import { choice } from "../lesson/choice.js";
import { number } from "../lesson/number.js";
import { revealNode, showReveal } from "../lesson/reveal.js";
import { sectors } from "../lesson/sectors.js";
import { setLanguage } from "../lesson/words.js";
import { put } from "../player/html.js";
import { on, send } from "../player/pipe.js";
import { write } from "../time/dom.js";
import { showInPlace } from "./place.js";
import { showSeat } from "./seat.js";
import { word } from "./words.js";

/**
 * @typedef {{
 *   id: string, kind: "choice" | "direction" | "number" | "sectors" | "moment", html: string,
 *   options: Array<[string, string]>, low: number, high: number, unit: string | null,
 *   language: string, ballot: number, round: number, open: boolean,
 * }} Ask
 * @typedef {{id: string, title: string, at: number, n: number, html: string, language: string}} Card
 * @typedef {{
 *   run: any, twenty: any, class: any, before: any, few: boolean,
 * }} Outcome
 * @typedef {{class: boolean, card: Card | null, ask: Ask | null, reveal: Outcome | null}} Lesson
 * @typedef {string | number | string[]} Value
 */

/** After so long what the lab says is true, whatever was chosen here. */
const PATIENCE_MS = 2_000;

/** @template {HTMLElement} T @param {string} id */
const part = (id) => /** @type {T} */ (document.getElementById(id));

const section = part("lesson");
const seatPlace = part("seat");
const cardPlace = part("card");
const cardOf = part("card-of");
const cardText = part("card-text");
const form = part("ask");
const fieldset = /** @type {HTMLFieldSetElement} */ (form.querySelector("fieldset"));
const legend = /** @type {HTMLElement} */ (form.querySelector("legend"));
const widgetPlace = /** @type {HTMLElement} */ (form.querySelector(".widget"));
const again = part("again");
const status = part("answered");
const take = part("take-seat");
part("came").append(revealNode);

/** @type {Lesson} */
let told = { class: false, card: null, ask: null, reveal: null };
/** @type {{seat: import("./seat.js").Seat | null, answer: Value | null} | null} */
let mine = null;
/** What was chosen here and has not come back yet. @type {{ballot: number, value: Value, at: number} | null} */
let draft = null;
/** @type {import("../lesson/ask.js").Widget | null} */
let widget = null;
let widgetOf = "";
let shownBallot = 0;
let wasSeated = false;

const isSame = (/** @type {unknown} */ one, /** @type {unknown} */ other) =>
  JSON.stringify(one) === JSON.stringify(other);

/** The answer as it is to be shown. @param {Ask} ask */
const answerOf = (ask) => {
  if (draft?.ballot !== ask.ballot) return mine?.answer ?? null;
  return draft.value;
};

/** @param {Ask} ask @param {Value} value */
const give = (ask, value) => {
  draft = { ballot: ask.ballot, value, at: performance.now() };
  send({ do: "answer", ballot: ask.ballot, value });
  show();
};

/** A question as those take it who draw it (`web/lesson`). @param {Ask} ask @returns {any} */
const asCard = (ask) => {
  // A trial is a whole number of trials, by a slider: the time bar is the presenter's.
  const unit = ask.kind === "moment" ? word("trial") : ask.unit;
  return { ...ask, unit };
};

/** @param {Ask} ask */
const makeWidget = (ask) => {
  const { id, kind, options, low, high, language } = ask;
  const now = JSON.stringify([id, kind, options, low, high, language, ask.ballot]);
  if (now === widgetOf) return;
  widgetOf = now;
  const makers = { choice, direction: choice, number, moment: number, sectors };
  widget = makers[kind](asCard(ask), (value, isDragged) => {
    if (!isDragged) give(ask, kind === "moment" ? Math.round(/** @type {number} */ (value)) : value);
  });
  widgetPlace.replaceChildren(widget.node);
};

/** What is to be said below a question. @param {Ask} ask @param {Value | null} answer */
const said = (ask, answer) => {
  if (!ask.open) return answer === null && !told.reveal?.class ? word("late") : "";
  const isThere = Array.isArray(answer) ? answer.length > 0 : answer !== null;
  if (!isThere) return word(ask.kind === "sectors" ? "chooseSeveral" : "choose");
  return isSame(answer, mine?.answer ?? null) ? word("sent") : word("waits");
};

/** @param {Card | null} card */
const showCard = (card) => {
  cardPlace.hidden = !card;
  if (!card) return;
  write(cardOf, word("card", card.title, card.at + 1, card.n));
  put(cardText, card.html);
};

/** @param {Ask | null} ask */
const showAsk = (ask) => {
  const isOpen = ask?.open ?? false;
  form.hidden = !ask || !isOpen;
  again.hidden = !(isOpen && ask && ask.round > 1);
  if (!ask) return;
  makeWidget(ask);
  // The card says it already, where there is one.
  put(legend, ask.html);
  legend.classList.toggle("unseen", told.card !== null);
  write(again, word("again"));
  fieldset.disabled = !isOpen;
  widget?.show(answerOf(ask));
  if (isOpen && ask.ballot !== shownBallot) {
    shownBallot = ask.ballot;
    section.scrollIntoView({ block: "start", behavior: "auto" });
  }
};

/** @param {Ask | null} ask @param {Outcome | null} reveal */
const showOutcome = (ask, reveal) => {
  if (!ask || !reveal) return showReveal(null);
  const html = reveal.few ? word("few") : "";
  const guess = mine?.answer ?? null;
  showReveal(/** @type {any} */ ({ id: `${ask.ballot}`, ask: asCard(ask), reveal: { ...reveal, html, ready: true, guess } }));
};

const show = () => {
  const { card, ask, reveal } = told;
  setLanguage(ask?.language ?? card?.language ?? "en");
  const seat = mine?.seat ?? null;
  const isSeated = told.class && seat !== null;
  section.hidden = !told.class && !card;
  showSeat(seatPlace, told.class ? seat : null);
  showCard(card);
  // What is going on, in words, is what a card asks for.
  part("sentence").hidden = card !== null;
  showAsk(isSeated || (ask && !ask.open) ? ask : null);
  showOutcome(ask, reveal);
  const asked = isSeated ? ask : null;
  showInPlace(asked, asked && answerOf(asked), reveal, (value) => asked && give(asked, value));
  const lacksSeat = told.class && mine !== null && !seat;
  take.hidden = !lacksSeat;
  write(take, word("takeSeat"));
  const waiting = told.class && !ask ? word("waiting") : "";
  write(status, lacksSeat ? word(wasSeated ? "ended" : "noSeat") : ask && isSeated ? said(ask, answerOf(ask)) : waiting);
};

on("lesson", (part) => {
  told = part;
  show();
});

on("seat", (part) => {
  mine = part;
  wasSeated ||= part.seat !== null;
  const { ask } = told;
  // It was on its way when the connection ended, or another page of this seat has answered since.
  if (draft && ask?.open && draft.ballot === ask.ballot && mine?.seat && !isSame(mine.answer, draft.value)) {
    const isNew = performance.now() - draft.at < PATIENCE_MS;
    if (mine.answer === null) send({ do: "answer", ballot: draft.ballot, value: draft.value });
    else if (!isNew) draft = null;
  } else draft = null;
  show();
});

form.addEventListener("submit", (event) => event.preventDefault());
take.addEventListener("click", () => location.reload());
