// @ts-check
// What the lab has said of the lesson, and what has been chosen here and is on its way to the lab.

import { drawing } from "../player/drawing.js";
import { send, sendNewest } from "../player/pipe.js";

/**
 * @typedef {[string, string]} Option its value, and its words with markup
 * @typedef {any} Answer of an option its value; a number or a trial; octants; values in their order; or
 * six pairs of a trial and a reward
 * @typedef {{
 *   kind: "choice" | "direction" | "number" | "sectors" | "moment" | "sketch" | "order",
 *   options: Option[], low: number | null, high: number | null, unit: string | null,
 *   from: number | null, to: number | null, confidence: boolean, answer: Answer | null,
 *   said: number | null, locked: boolean,
 * }} Ask
 * @typedef {{n: number} & Record<string, any>} Many what several runs, or people, came to
 * @typedef {{
 *   ready: boolean, asked?: Ask, html: string, guess: Answer | null, run: Answer | null, twenty: Many | null,
 *   class?: Many | null, before?: Many | null,
 * }} Reveal `asked` is what was guessed, which may be of an earlier card; `before` is what the class chose first, where it has voted again
 * @typedef {{verdict: "yes" | "not yet" | "never", html: string}} Check
 * @typedef {{
 *   kind: string, id: string, html: string, ask: Ask | null, reveal: Reveal | null,
 *   check: Check | null, hints: string[], next_hint: "says" | "does" | null, busy: string | null,
 * }} Card
 * @typedef {{
 *   control: string, label: string, kind: "button" | "toggle" | "slider" | "choice", value: any,
 *   options?: Array<[any, string]>, on: boolean, why?: string, main?: boolean,
 * }} Control
 * @typedef {{
 *   code: string | null, address: string | null, seats: number, answered: number, asking: boolean,
 *   hidden: boolean, few: boolean, can: string[],
 * }} Vote
 * @typedef {{
 *   name: string, title: string, language: string, languages: string[], n: number, at: number,
 *   furthest: number, show: string[], keys: string[], card: Card, controls: Control[],
 *   inspect: string | null, notes: string | null, next: boolean, last: boolean, said: string,
 *   vote: Vote | null,
 * }} Lesson
 * @typedef {{
 *   name: string, titles: Titles, minutes: number, needs: Titles[], languages: string[],
 *   at: number | null, n: number,
 * }} Listed
 * @typedef {Record<string, string>} Titles of one lesson, by language; its own comes first
 * @typedef {{list: Listed[], fault: string | null, free: boolean, lesson: Lesson | null}} Told
 */

/** @type {{told: Told | null, listing: boolean}} `listing` while all lessons are looked at in one */
export const state = { told: null, listing: false };

export const { whenChanged, changed } = drawing();

/** The lesson whose card is shown. */
export const lessonShown = () => (state.listing || state.told?.free ? null : (state.told?.lesson ?? null));

// --- What was chosen here --------------------------------------------------------------------------

/** After so long what the lab says is true, if it has said anything else since, or what is wrong. */
const PATIENCE_MS = 1_500;

/**
 * What has been chosen of each card; `before` is what the lab said then, as JSON.
 * @type {Map<string, {answer: Answer, before: string, at: number}>}
 */
const drafts = new Map();
/** How sure somebody is, by cards: the lab is told with the answer. @type {Map<string, number>} */
const sure = new Map();

/** @param {Card} card */
const keyOf = (card) => `${state.told?.lesson?.name} ${card.id} ${card.ask?.kind}`;

/** The answer as it is to be shown. @param {Card} card @returns {Answer | null} */
export const answerOf = (card) => {
  const { ask } = card;
  const draft = drafts.get(keyOf(card));
  if (!ask || !draft) return ask?.answer ?? null;
  const told = JSON.stringify(ask.answer);
  const isSettled = ask.locked || told === JSON.stringify(draft.answer);
  // A lab that has much to do may take long to hear of it.
  const isOnItsWay = told === draft.before && !state.told?.fault;
  if (!isSettled && (isOnItsWay || performance.now() - draft.at < PATIENCE_MS)) return draft.answer;
  drafts.delete(keyOf(card));
  return ask.answer;
};

/**
 * Choose an answer, which may be changed until it is committed.
 * @param {Card} card
 * @param {Answer} answer
 * @param {boolean} [isDragged] whether another one comes in a moment
 */
export const giveAnswer = (card, answer, isDragged = false) => {
  drafts.set(keyOf(card), { answer, before: JSON.stringify(card.ask?.answer ?? null), at: performance.now() });
  (isDragged ? sendNewest : send)({ do: "answer", id: card.id, value: answer });
  changed();
};

/** @param {Card} card */
export const sureOf = (card) => card.ask?.said ?? sure.get(keyOf(card)) ?? null;

/** @param {Card} card @param {number} percent */
export const setSure = (card, percent) => {
  sure.set(keyOf(card), percent);
  changed();
};
