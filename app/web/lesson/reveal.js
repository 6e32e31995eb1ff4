// @ts-check
// What came out, as a small picture: what was expected, this run, and other runs together. Nobody is
// told right or wrong by it: a run is one of many.

import { put } from "../player/html.js";
import { OCTANTS } from "../player/octants.js";
import { element, write } from "../time/dom.js";
import { RADII, compass, middle, svgElement, wedge } from "./compass.js";
import { curves } from "./curves.js";
import { line } from "./line.js";
import { MANY, nameOf, row, swatch } from "./marks.js";
import { numeral, word } from "./words.js";

/**
 * @typedef {import("./state.js").Ask} Ask
 * @typedef {import("./state.js").Card} Card
 * @typedef {import("./state.js").Many} Many
 * @typedef {import("./state.js").Reveal} Reveal
 * @typedef {Reveal & {saw: import("./state.js").Answer | null}} Told with what somebody says to have seen
 * @typedef {(reveal: Told, ask: Ask) => HTMLElement} Picture
 */

export const revealNode = element("section", "reveal");
const heading = element("h2", "", "");
const words = element("p", "words");
const picture = element("div", "picture");
const sure = element("p", "sure-of-it");
// It is there before there is anything to say, so that it is heard.
words.setAttribute("role", "status");
revealNode.append(heading, picture, sure, words);

/** A share of several as a bar. @param {string} kind @param {number} share */
const bar = (kind, share) => {
  const track = element("span", `bar ${kind}`);
  const filled = element("i", "");
  filled.style.width = `${100 * Math.min(Math.max(share, 0), 1)}%`;
  track.append(filled);
  return track;
};

/** Bars of options, each with who chose it, or came to it. @type {Picture} */
const bars = (reveal, { options }) => {
  const { guess, saw, run } = reveal;
  const table = element("ul", "bars");
  for (const [value, html] of options) {
    const item = element("li", "");
    const name = element("div", "name");
    put(name.appendChild(element("span", "")), html);
    for (const [whose, chosen] of /** @type {const} */ ([["guess", guess], ["saw", saw], ["run", run]])) {
      if (chosen !== value) continue;
      const mark = element("span", `mark ${whose}`);
      mark.append(swatch(whose), nameOf(whose));
      name.append(mark);
    }
    item.append(name);
    for (const whose of MANY) {
      const counted = reveal[whose];
      if (!counted) continue;
      const count = counted.counts[value] ?? 0;
      const shown = element("div", "counted");
      const of = element("span", "of", word("ofRuns", numeral(count), numeral(counted.n)));
      of.title = nameOf(whose, counted);
      shown.append(bar(whose, count / Math.max(counted.n, 1)), of);
      item.append(shown);
    }
    table.append(item);
  }
  const node = element("div", "options");
  const whose = element("p", "whose");
  for (const who of MANY) {
    const counted = reveal[who];
    if (!counted) continue;
    const named = element("span", "");
    named.append(swatch(who), nameOf(who, counted));
    whose.append(named);
  }
  node.append(table, whose);
  return node;
};

/** Three rings round the prey: what was expected, this run, and in how many others. @type {Picture} */
const rings = (reveal) => {
  const { guess, saw, run } = reveal;
  const node = element("div", "rings");
  const svg = compass();
  svg.setAttribute("aria-hidden", "true");
  /** @type {Array<[import("./marks.js").Whose, (octant: string) => number, Many | null]>} */
  const bands = [];
  for (const [whose, octants] of /** @type {const} */ ([["guess", guess], ["saw", saw], ["run", run]]))
    if (octants) bands.push([whose, (octant) => Number(octants.includes(octant)), null]);
  for (const whose of MANY) {
    const counted = reveal[whose];
    if (counted) bands.push([whose, (octant) => (counted.counts[octant] ?? 0) / Math.max(counted.n, 1), counted]);
  }
  const broad = (RADII.outer - RADII.prey) / bands.length;
  bands.forEach(([whose, shareOf, counted], ring) => {
    const inner = RADII.prey + ring * broad;
    OCTANTS.forEach((octant, index) => {
      const share = shareOf(octant);
      const part = svgElement("path", { d: wedge(index, inner + 1, inner + broad - 1), class: `band of-${whose}` });
      part.style.setProperty("--share", `${share}`);
      part.toggleAttribute("data-chosen", share > 0);
      svg.append(part);
      if (!counted) return;
      const { x, y } = middle(index, inner + broad / 2);
      const text = svgElement("text", { x, y });
      text.textContent = `${counted.counts[octant] ?? 0}`;
      svg.append(text);
    });
  });
  // The picture says it to those who see it; which ring is whose, it does not.
  const list = document.createElement("dl");
  const named = (/** @type {string[] | null} */ octants) =>
    OCTANTS.filter((octant) => octants?.includes(octant)).map((octant) => word(octant)).join("; ") || word("none");
  if (guess) list.append(row("guess", nameOf("guess"), named(guess)));
  if (saw) list.append(row("saw", nameOf("saw"), named(saw)));
  if (run) list.append(row("run", nameOf("run"), named(run)));
  for (const whose of MANY) {
    const counted = reveal[whose];
    if (counted) {
      const often = OCTANTS.filter((octant) => counted.counts[octant]).map(
        (octant) => `${word(octant)} ${counted.counts[octant]}`,
      );
      list.append(row(whose, nameOf(whose, counted), often.join("; ") || word("none")));
    }
  }
  for (const value of list.querySelectorAll("dd")) value.className = "unseen";
  node.append(svg, element("p", "whose", word("rings")), list);
  return node;
};

/** One order beside the other. @type {Picture} */
const orders = ({ guess, run, twenty }, { options }) => {
  const table = document.createElement("table");
  table.className = "orders";
  const names = new Map(options);
  const head = table.insertRow();
  for (const whose of /** @type {const} */ (["guess", "run"])) {
    const cell = document.createElement("th");
    cell.scope = "col";
    cell.append(swatch(whose), nameOf(whose));
    head.append(cell);
  }
  options.forEach((_, place) => {
    const line = table.insertRow();
    for (const [whose, values] of /** @type {const} */ ([["guess", guess], ["run", run]])) {
      const cell = line.insertCell();
      const value = values?.[place];
      if (value === undefined) continue;
      cell.append(`${place + 1}. `);
      put(cell.appendChild(element("span", "")), names.get(value) ?? "");
      const counted = whose === "run" ? twenty?.counts[value]?.[place] : undefined;
      if (counted !== undefined && twenty)
        cell.append(element("small", "", word("atPlace", counted, twenty.n)));
    }
  });
  return table;
};

/** @type {Record<Ask["kind"], Picture>} */
const PICTURES = {
  choice: bars,
  direction: bars,
  number: line,
  moment: line,
  sectors: rings,
  sketch: curves,
  order: orders,
};

let key = "";

/** Of nobody there is nothing to draw. @param {Many | null | undefined} many */
const orNone = (many) => (many?.n ? many : null);

/** @param {Card | null} card @returns {Reveal | null} */
const revealOf = (card) => {
  const reveal = card?.reveal;
  if (!reveal) return null;
  const [twenty, before, many] = [reveal.twenty, reveal.before, reveal.class].map(orNone);
  return { ...reveal, twenty, before, class: many };
};

/** Whether there is a picture of what came out. @param {Card | null} card */
export const isPictured = (card) => {
  const [reveal, ask] = [revealOf(card), card?.ask ?? null];
  return (reveal?.asked ?? ask) !== null && reveal !== null && ["run", ...MANY].some((whose) => (/** @type {any} */ (reveal)[whose] ?? null) !== null);
};

/** @param {Card | null} card */
export const showReveal = (card) => {
  const found = revealOf(card);
  // Before there is anything to tell it is there, but not to be seen: what is told is heard then.
  const reveal = found?.ready || isPictured(card) || card?.ask?.locked ? found : null;
  const ask = reveal?.asked ?? card?.ask ?? null;
  revealNode.classList.toggle("unseen", !reveal);
  if (!reveal) {
    for (const node of [heading, picture, sure, words]) node.replaceChildren();
    put(words, "");
    key = "";
    return;
  }
  write(heading, word("wasSo"));
  const now = JSON.stringify([card?.id, card?.ask?.answer, reveal, ask, document.documentElement.lang]);
  if (now === key) return;
  key = now;
  // What was asked again, of what is seen, is no guess.
  const saw = card?.kind === "see" ? (card.ask?.answer ?? null) : null;
  picture.replaceChildren(...(ask && isPictured(card) ? [PICTURES[ask.kind]({ ...reveal, saw }, ask)] : []));
  write(sure, ask?.said ? word("wereSure", ask.said) : "");
  put(words, reveal.ready || reveal.html ? reveal.html : word("twentyWait"));
};
