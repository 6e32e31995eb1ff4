// @ts-check
// One card of a lesson: where it is among all, what it says and asks, and the one thing to do next.

import { put } from "../player/html.js";
import { send } from "../player/pipe.js";
import { attribute, element, write } from "../time/dom.js";
import { askNode, missing, showAsk } from "./ask.js";
import { checkNode, showCheck } from "./check.js";
import { controlsNode, showControls, useMain } from "./controls.js";
import { revealNode, showReveal } from "./reveal.js";
import { answerOf, changed, lessonShown, state, sureOf, whenChanged } from "./state.js";
import { showVote, voteNode } from "./vote.js";
import { setLanguage, word } from "./words.js";

/**
 * @typedef {import("./state.js").Card} Card
 * @typedef {import("./state.js").Lesson} Lesson
 * @typedef {{text: string, why: string, isOn: boolean, act: () => unknown}} Primary
 */

const page = element("div", "lesson");
page.innerHTML = `
  <header>
    <p class="title"></p>
    <div class="ways">
      <button type="button" class="quiet all"></button>
      <select class="language"></select>
      <button type="button" class="quiet free"></button>
    </div>
    <nav class="dots"><ol></ol></nav>
  </header>
  <main>
    <h1 tabindex="-1"><span class="unseen"></span><span class="kind"></span></h1>
    <div class="text"></div>
    <p class="fault" role="alert"></p>
    <p class="said" role="status"></p>
  </main>
  <footer>
    <p class="why" role="status"></p>
    <button type="button" class="back"></button>
    <button type="button" class="primary"></button>
  </footer>`;
const part = (/** @type {string} */ name) => /** @type {HTMLElement} */ (page.querySelector(name));
const inspect = element("details", "inspect");
inspect.append(element("summary", ""), element("div", "pounce"));
const notes = document.createElement("details");
notes.className = "notes";
notes.append(element("summary", ""), element("div", ""));
part("main").append(voteNode, askNode, revealNode, checkNode, controlsNode, inspect, notes);
document.body.append(page);

const dots = part(".dots ol");
const language = /** @type {HTMLSelectElement} */ (part(".language"));
const heading = part("h1");
const primary = part(".primary");
/** Which card has been shown, so that a new one is begun at its heading. */
let shown = "";
/** What the button said on which the first of several quick clicks fell. */
let pressed = "";

/** A card is free by its name alone where all is open. @param {Card} card */
const kindOf = (card) => (card.kind === "free" ? "freely" : card.kind);

/** @param {Lesson} lesson */
const showDots = ({ n, at, furthest }) => {
  part(".dots").ariaLabel = word("cards");
  dots.style.setProperty("--n", `${n}`);
  while (dots.children.length > n) dots.lastChild?.remove();
  while (dots.children.length < n) {
    const card = dots.children.length;
    const button = element("button", "");
    button.setAttribute("type", "button");
    button.append(element("i", ""));
    button.addEventListener("click", () => {
      if (button.ariaDisabled !== "true") send({ do: "go", card });
    });
    dots.appendChild(document.createElement("li")).append(button);
  }
  [...dots.children].forEach((item, card) => {
    const button = /** @type {HTMLElement} */ (item.firstElementChild);
    const label = word("card", card + 1, n);
    attribute(button, "aria-label", label);
    attribute(button, "title", label);
    attribute(button, "aria-current", card === at ? "step" : null);
    attribute(button, "aria-disabled", card > furthest ? "true" : null);
    // Nowhere to go to is no stop of the keyboard.
    button.tabIndex = card > furthest ? -1 : 0;
    item.toggleAttribute("data-passed", card < at);
  });
};

/** @param {Lesson} lesson */
const showLanguages = ({ languages, language: chosen }) => {
  language.hidden = languages.length < 2;
  language.ariaLabel = word("language");
  const key = languages.join();
  if (language.dataset.key !== key) {
    language.dataset.key = key;
    language.replaceChildren(...languages.map((each) => new Option(word(each), each)));
  }
  if (document.activeElement !== language) language.value = chosen;
};

/** @param {Card} card */
const commit = (card) => {
  const { ask } = card;
  // The order that things stand in is an answer, though nobody has moved one.
  const asItStands = ask?.kind === "order" ? ask.options.map(([value]) => value) : null;
  const answer = answerOf(card) ?? asItStands;
  // What is committed is what is seen, though it may have been lost with a connection.
  if (JSON.stringify(answer) !== JSON.stringify(ask?.answer)) send({ do: "answer", id: card.id, value: answer });
  send({ do: "commit", id: card.id, confidence: ask?.confidence ? sureOf(card) : null });
};

/** The thing to do that stands below the card, if it is a single one. @param {Lesson} lesson */
const mainOf = ({ card, controls, next }) => {
  // What is waited for at the moment before is that it be done there.
  const isOver = next || (card.check?.verdict === "never" && !card.busy);
  if (isOver || (card.ask && !card.ask.locked)) return null;
  const main = controls.filter((control) => control.main && control.kind === "button");
  return main.length === 1 ? main[0] : null;
};

/** @param {Lesson} lesson @returns {Primary} */
const primaryOf = (lesson) => {
  const { card, next, last } = lesson;
  if (card.ask && !card.ask.locked) {
    const why = missing(card);
    return { text: word("commit"), why, isOn: !why, act: () => commit(card) };
  }
  const main = mainOf(lesson);
  if (main) return { text: main.label, why: main.on ? "" : (main.why ?? ""), isOn: main.on, act: () => useMain(main) };
  if (card.check?.verdict === "never") {
    return { text: word("rewind"), why: "", isOn: true, act: () => send({ do: "rewind" }) };
  }
  const why = next ? "" : (card.busy ?? word(card.check ? "notYet" : "waits"));
  if (last) {
    const isOver = !card.busy && (card.check?.verdict ?? "yes") === "yes";
    return { text: word("finish"), why: isOver ? "" : why, isOn: isOver, act: () => send({ do: "leave" }) };
  }
  return { text: word("next"), why, isOn: next, act: () => send({ do: "next" }) };
};

/** @param {Lesson} lesson */
const showFooter = (lesson) => {
  const { text, why, isOn } = primaryOf(lesson);
  write(primary, text);
  // It keeps the focus while there is nothing to do.
  attribute(primary, "aria-disabled", isOn ? null : "true");
  write(part(".why"), lesson.card.busy ?? why);
  part(".why").toggleAttribute("data-busy", lesson.card.busy !== null);
  const back = part(".back");
  write(back, word("back"));
  back.hidden = lesson.at === 0;
};

/** @param {Lesson} lesson */
const begin = (lesson) => {
  const key = `${lesson.name} ${lesson.at} ${lesson.card.id}`;
  if (key === shown) return;
  shown = key;
  page.scrollTop = 0;
  part("main").scrollTop = 0;
  heading.focus({ preventScroll: true });
};

whenChanged(() => {
  const lesson = lessonShown();
  page.hidden = !lesson;
  if (!lesson) {
    shown = "";
    return;
  }
  setLanguage(lesson.language);
  const { card } = lesson;
  page.dataset.kind = card.kind;
  write(part(".title"), lesson.title);
  write(part(".all"), word("lessons"));
  write(part(".free"), word("free"));
  attribute(part(".free"), "title", word("freeHint"));
  showDots(lesson);
  showLanguages(lesson);
  write(part("h1 > .unseen"), `${lesson.title}. ${word("card", lesson.at + 1, lesson.n)}. `);
  write(part("h1 > .kind"), word(kindOf(card)));
  put(part(".text"), card.html);
  write(part(".fault"), state.told?.fault ?? "");
  write(part(".said"), lesson.said);
  showAsk(card);
  showReveal(card);
  showCheck(card);
  // Where all is open, all of them are in the panels.
  showControls(lesson.show.includes("all") ? [] : lesson.controls, mainOf(lesson));
  inspect.hidden = !lesson.inspect;
  write(/** @type {Element} */ (inspect.firstElementChild), word("inspect"));
  put(/** @type {Element} */ (inspect.lastElementChild), lesson.inspect ?? "");
  showVote(lesson.vote);
  // What came out is seen on the projector without scrolling; before that, what the class is asked.
  if (card.reveal ? revealNode.nextSibling !== voteNode : voteNode.nextSibling !== askNode) {
    if (card.reveal) revealNode.after(voteNode);
    else askNode.before(voteNode);
  }
  notes.hidden = !lesson.notes;
  write(/** @type {Element} */ (notes.firstElementChild), word("notes"));
  put(/** @type {Element} */ (notes.lastElementChild), lesson.notes ?? "");
  showFooter(lesson);
  // What is scrolled can be scrolled by keys, too.
  const main = part("main");
  attribute(main, "tabindex", main.scrollHeight > main.clientHeight ? "0" : null);
  begin(lesson);
});

primary.addEventListener("click", ({ detail }) => {
  const lesson = lessonShown();
  const what = lesson && primaryOf(lesson);
  // Nobody means what the button is about to become and is not drawn as yet, nor with a double click
  // what it has become by the first one.
  if (detail <= 1) pressed = primary.textContent;
  if (what?.isOn && what.text === pressed) what.act();
});
part(".back").addEventListener("click", () => send({ do: "back" }));
part(".free").addEventListener("click", () => send({ do: "free" }));
part(".all").addEventListener("click", () => {
  state.listing = true;
  changed();
});
language.addEventListener("change", () => send({ do: "language", language: language.value }));
