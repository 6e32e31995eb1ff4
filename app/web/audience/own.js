// @ts-check
// A learner of one's own: its board, how it fares, and the few things that one can do with it. What
// there is to press is decided where it is sent from (app/audience/own_view.py); what is shown here is
// how the learner stands, and not what was pressed.

import { Board } from "../player/board.js";
import { put } from "../player/html.js";
import { on, send } from "../player/pipe.js";
import { element } from "../time/dom.js";

/**
 * @typedef {{do: string} & Record<string, unknown>} Says
 * @typedef {object} Told
 * @property {string} control
 * @property {"button" | "choice" | "level"} kind
 * @property {string} label
 * @property {boolean} [on] whether it can be pressed
 * @property {Says | null} [says] of a button
 * @property {[string, Says][]} [options] of a choice
 * @property {string} [note]
 * @property {number} [level]
 * @property {string[]} [words] of each level
 *
 * @typedef {{node: HTMLElement, take: (told: Told) => void}} Control
 */

/** What is said aloud is said no more often. */
const SAID_MS = 10_000;

/** @param {string} id */
const part = (id) => /** @type {HTMLElement} */ (document.getElementById(id));

const board = new Board(/** @type {HTMLCanvasElement} */ (part("own-board")));
const place = part("own-controls");
const notice = part("own-notice");

/** @param {HTMLElement} node @param {string} text */
const write = (node, text) => {
  if (node.textContent !== text) node.textContent = text;
  node.hidden = !text;
};

/** Something to press; of several things, the one that is chosen beside it. @returns {Control} */
const presser = () => {
  const node = element("div", "own-control");
  const select = /** @type {HTMLSelectElement} */ (document.createElement("select"));
  const button = /** @type {HTMLButtonElement} */ (document.createElement("button"));
  const note = element("small", "");
  button.type = "button";
  node.append(select, button, note);
  /** @type {Told} */
  let told;
  let offered = "";
  const chosen = () => told.options?.[Math.max(select.selectedIndex, 0)];
  const name = () => {
    const single = told.options?.length === 1 ? ` ${told.options[0][0]}` : "";
    write(button, `${told.label}${single}`);
  };
  button.addEventListener("click", () => {
    const says = told.options ? chosen()?.[1] : told.says;
    if (says && send(says)) node.toggleAttribute("data-asked", true);
  });
  return {
    node,
    take: (now) => {
      told = now;
      const options = now.options ?? [];
      const names = options.map(([text]) => text).join("\n");
      if (names !== offered) {
        offered = names;
        const before = select.value;
        select.replaceChildren(...options.map(([text]) => new Option(text, text)));
        if (options.some(([text]) => text === before)) select.value = before;
      }
      select.hidden = options.length < 2;
      select.setAttribute("aria-label", now.label);
      // A button that holds the focus keeps it: so it is not disabled, but says that it cannot.
      button.setAttribute("aria-disabled", `${!now.on}`);
      name();
      write(note, now.note ?? "");
      node.removeAttribute("data-asked");
    },
  };
};

/** So long what was set here stands, unless the lab has said the same before. */
const PATIENCE_MS = 20_000;

/** One of a few levels. @returns {Control} */
const leveller = () => {
  const node = element("div", "own-control own-level");
  const name = element("span", "");
  const output = element("output", "");
  const range = /** @type {HTMLInputElement} */ (document.createElement("input"));
  range.type = "range";
  range.min = "0";
  range.step = "1";
  node.append(name, output, range);
  /** @type {Told} */
  let told;
  let isHeld = false;
  /** What was set here and has not come back: what comes until then was said before it. @type {{level: number, at: number} | null} */
  let wished = null;
  const say = () => {
    const words = told.words?.[Number(range.value)] ?? "";
    write(output, words);
    range.setAttribute("aria-valuetext", words);
  };
  range.addEventListener("pointerdown", () => (isHeld = true));
  for (const end of ["pointerup", "pointercancel"]) range.addEventListener(end, () => (isHeld = false));
  range.addEventListener("input", say);
  range.addEventListener("change", () => {
    const level = Number(range.value);
    if (send({ do: "own_speed", level })) wished = { level, at: performance.now() };
  });
  return {
    node,
    take: (now) => {
      told = now;
      write(name, now.label);
      range.setAttribute("aria-label", now.label);
      range.max = `${(now.words?.length ?? 1) - 1}`;
      if (wished && (now.level === wished.level || performance.now() - wished.at > PATIENCE_MS)) wished = null;
      // Not from under a hand.
      if (!isHeld && !wished) range.value = `${now.level}`;
      say();
    },
  };
};

/** @type {Map<string, Control>} */
const controls = new Map();

on("own", (stand) => {
  part("own").toggleAttribute("data-none", !stand.whose);
  write(part("own-whose"), stand.whose);
  write(notice, stand.busy || stand.notice);
  /** @type {Told[]} */
  const told = stand.controls;
  for (const [key, { node }] of controls) {
    if (told.some(({ control }) => control === key)) continue;
    node.remove();
    controls.delete(key);
  }
  told.forEach((one, index) => {
    let control = controls.get(one.control);
    if (!control) {
      control = one.kind === "level" ? leveller() : presser();
      controls.set(one.control, control);
    }
    control.take(one);
    // Whatever stands where it is to stay keeps the focus.
    if (place.children[index] !== control.node) place.insertBefore(control.node, place.children[index] ?? null);
  });
});

on("own_world", ({ world }) => board.world(world));
on("own_ground", ({ board: sent }) => board.show(sent));
on("own_over", ({ board: sent }) => board.show(sent));

let saidAt = -SAID_MS;
let timer = 0;
on("own_words", ({ sentence, readings, described, legend }) => {
  put(part("own-sentence"), sentence);
  put(part("own-readings"), readings);
  put(part("own-legend"), legend);
  board.describe(described);
  clearTimeout(timer);
  const aloud = () => {
    saidAt = performance.now();
    part("own-told").textContent = part("own-sentence").textContent;
  };
  timer = setTimeout(aloud, Math.max(saidAt + SAID_MS - performance.now(), 0));
});
