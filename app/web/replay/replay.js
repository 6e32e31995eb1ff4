// @ts-check
// The replay page: a film, shown by the lab's own board and time bar.

import "../terms.js";
import { Board } from "../player/board.js";
import { put } from "../player/html.js";
import { send } from "../player/pipe.js";
import "../time/draw.js";
import { KEYS } from "../time/keys.js";
import { ACTS } from "../time/transport.js";
import "../time/hand.js";
import "../time/tip.js";
import "../time/told.js";
import { openFilm } from "./film.js";
import { alone } from "./heading.js";
import { onKeys } from "./keys.js";
import { isDark, switchScheme, whenScheme } from "../player/scheme.js";
import { follow } from "./sink.js";
import { Walk } from "./walk.js";

const EACH = "each";
const TURNED = "turned";

/** @param {string} id */
const part = (id) => /** @type {HTMLElement} */ (document.getElementById(id));

const data = JSON.parse(part("replay-data").textContent ?? "");
const layers = /** @type {HTMLButtonElement[]} */ ([...document.querySelectorAll("[data-layer]")]);
const frame = /** @type {HTMLSelectElement} */ (part("frame"));

/** What is seen of a moment. */
const look = { layer: layers[0].dataset.layer ?? "", frame: TURNED };

/**
 * What has its place in the page is put there, wherever it was made.
 */
const arrange = () => {
  const bar = part("bar");
  for (const name of [".transport", ".told", ".time"]) {
    const made = document.querySelector(`body > ${name}`);
    if (made) bar.append(made);
  }
  part("poster").remove();
  part("board").hidden = part("ways").hidden = part("scheme").hidden = false;
  for (const hidden of document.querySelectorAll(".how")) hidden.removeAttribute("hidden");
};

const begin = async () => {
  const film = await openFilm(part("replay-film").textContent ?? "");
  const walk = new Walk(data.lines, data.line, film.shots);
  const board = new Board(/** @type {HTMLCanvasElement} */ (part("board")));
  board.world(data.world);
  let drawn = "";

  const show = () => {
    const { layer } = look;
    const shot = walk.shot;
    const now = [shot, layer, look.frame, isDark()].join();
    if (now === drawn) return;
    drawn = now;
    const heading = Number(look.frame);
    const name = `${layer}/${look.frame === TURNED ? TURNED : EACH}`;
    const sent = film.board(name, shot, isDark());
    board.show(Number.isNaN(heading) ? sent : alone(sent, heading, data.world));
    const [light, dark, caption, about] = film.said(name, shot);
    board.describe(about);
    put(part("legend"), isDark() ? dark : light);
    if (part("caption").textContent !== caption) part("caption").textContent = caption;
    const [sentence, readings] = film.shots[shot].said;
    put(part("sentence"), sentence);
    put(part("readings"), readings);
    for (const button of layers) button.setAttribute("aria-pressed", `${button.dataset.layer === layer}`);
    markEvents(film.shots[shot].step);
  };

  /** What has happened by a step of the line is marked. @param {number} step */
  const markEvents = (step) => {
    for (const row of /** @type {Iterable<HTMLElement>} */ (document.querySelectorAll("tr[data-step]")))
      row.toggleAttribute("data-past", Number(row.dataset.line) === walk.line && Number(row.dataset.step) <= step);
  };

  /** @param {string} layer */
  const showLayer = (layer) => {
    look.layer = layer;
    show();
  };
  const showFrame = (/** @type {string} */ name) => {
    look.frame = frame.value = name;
    show();
  };

  arrange();
  follow(walk, new Map(Object.entries(data.bars).map(([line, bars]) => [Number(line), bars])), show);
  for (const button of layers) button.addEventListener("click", () => showLayer(button.dataset.layer ?? ""));
  frame.addEventListener("change", () => showFrame(frame.value));
  frame.value = look.frame;
  // A click on one of all headings shows it alone, and one on that all of them again.
  part("board").addEventListener("click", ({ clientX, clientY }) => {
    const cell = board.cellAt(clientX, clientY);
    if (look.frame === EACH && cell?.heading != null) showFrame(`${cell.heading}`);
    else if (look.frame !== EACH && look.frame !== TURNED) showFrame(EACH);
  });
  part("scheme").addEventListener("click", switchScheme);
  whenScheme(show);
  for (const row of /** @type {Iterable<HTMLElement>} */ (document.querySelectorAll("tr[data-step]"))) {
    const place = /** @type {HTMLElement} */ (row.querySelector("th"));
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = place.textContent;
    button.setAttribute("aria-label", `Go to trial ${place.textContent}: ${row.lastElementChild?.textContent}`);
    place.replaceChildren(button);
    button.addEventListener("click", () => {
      walk.look(Number(row.dataset.line));
      goTo(Number(row.dataset.step));
      // What was asked for is to be seen.
      document.body.scrollIntoView();
    });
  }
  onKeys({
    ...KEYS,
    Space: ACTS.play,
    KeyD: switchScheme,
    KeyV: () => showFrame(look.frame === TURNED ? EACH : TURNED),
    ...Object.fromEntries(layers.map(({ dataset }, n) => [`Digit${n + 1}`, () => showLayer(dataset.layer ?? "")])),
  });
  document.documentElement.dataset.ready = "";
};

/** @param {number} step */
const goTo = (step) => send({ do: "seek", step });

begin().catch((error) => {
  part("told").textContent = `This page cannot play here: ${error}. Below are its pictures.`;
  part("told").classList.remove("unseen");
});
