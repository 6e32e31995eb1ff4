// @ts-check
// What can be done with a line of the tree and with a mark: menus, and a name that is edited in place.

import { send } from "../player/pipe.js";
import { element } from "./dom.js";
import { openField } from "./field.js";
import { say } from "./said.js";
import { MOST_CHARACTERS, state } from "./state.js";

/** @typedef {import("./state.js").Line} Line */

const MARGIN_PX = 2;

/** @param {EventTarget | null} target */
const elementAt = (target) =>
  /** @type {HTMLElement | null} */ (/** @type {Element | null} */ (target)?.closest(".line") ?? null);

/** @param {HTMLElement | null} row */
const lineOf = (row) => state.bar?.lines.find(({ line }) => `${line}` === row?.dataset.line);

/** @param {Line} line */
const elementOf = ({ line }) =>
  /** @type {HTMLElement | null} */ (document.querySelector(`.line[data-line="${line}"]`));

// --- Its name --------------------------------------------------------------------------------------

/** @param {Line} line */
const rename = (line) => {
  const row = elementOf(line);
  const shown = row?.querySelector(".name") ?? row;
  if (!shown) return;
  const { field, close } = openField(shown, {
    name: "name-field",
    label: `Name of ${line.name}`,
    value: line.name,
    isCentred: false,
    end: (isTaken) => {
      const name = field.value.trim();
      // By no name it is called as it was at first.
      if (isTaken && name !== line.name) send({ do: "name", line: line.line, name });
    },
    goBack: () => elementOf(line)?.focus({ preventScroll: true }),
  });
  field.maxLength = MOST_CHARACTERS;
  field.addEventListener("keydown", (event) => {
    if (event.key !== "Enter" && event.key !== "Escape") return;
    event.preventDefault();
    close(event.key === "Enter");
  });
  field.addEventListener("blur", () => close(true));
};

// --- The menu --------------------------------------------------------------------------------------

/** @param {Line} line */
const remove = ({ line, name }) => {
  send({ do: "delete_line", line });
  say(`${name} is deleted.`, {
    label: "Undo",
    act: () => send({ do: "bring_back", line }),
  });
};

/**
 * What can be done with a line, by what it is called.
 * @param {Line} line
 * @returns {Array<[string, () => unknown]>}
 */
const choices = (line) => [
  ["Look at it", () => send({ do: "look", line: line.line })],
  ...(state.bar?.recorded ? [] : changes(line)),
];

/**
 * What of a line can be changed.
 * @param {Line} line
 * @returns {Array<[string, () => unknown]>}
 */
const changes = (line) => [
  ["Rename", () => rename(line)],
  ["Test over 30 seeds", () => send({ do: "test", line: line.line })],
  ...(line.live
    ? []
    : /** @type {Array<[string, () => unknown]>} */ ([
        ["Make it live", () => send({ do: "make_live", line: line.line })],
        ["Delete", () => remove(line)],
      ])),
];

let close = () => {};

/**
 * @param {Element} place where it opens
 * @param {string} name what it is for
 * @param {Array<[string, () => unknown]>} choices
 */
const open = (place, name, choices) => {
  close();
  const menu = element("div", "menu");
  menu.setAttribute("role", "menu");
  menu.setAttribute("aria-label", name);
  const items = choices.map(([label, act]) => {
    const item = /** @type {HTMLButtonElement} */ (element("button", "", label));
    item.type = "button";
    item.tabIndex = -1;
    item.setAttribute("role", "menuitem");
    item.addEventListener("click", () => {
      close();
      act();
    });
    return item;
  });
  menu.append(...items);
  document.body.append(menu);
  const box = place.getBoundingClientRect();
  const former = /** @type {HTMLElement | null} */ (document.activeElement);
  const { clientWidth, clientHeight } = document.documentElement;
  // Nothing of it may lie beside the frame, which is low.
  const left = Math.min(box.left, clientWidth - menu.offsetWidth - MARGIN_PX);
  const top = Math.min(box.bottom, clientHeight - menu.offsetHeight - MARGIN_PX);
  menu.style.left = `${Math.max(left, MARGIN_PX)}px`;
  menu.style.top = `${Math.max(top, 0)}px`;
  items[0].focus();

  close = () => {
    close = () => {};
    const hadFocus = menu.contains(document.activeElement);
    menu.remove();
    if (hadFocus) former?.focus({ preventScroll: true });
  };
  menu.addEventListener("keydown", (event) => {
    const place = items.indexOf(/** @type {HTMLButtonElement} */ (document.activeElement));
    const next = { ArrowDown: place + 1, ArrowUp: place - 1, Home: 0, End: -1 }[event.key];
    if (next !== undefined) items.at(next % items.length)?.focus();
    else if (event.key === "Escape" || event.key === "Tab") close();
    else if (event.key === "Enter" || event.key === " ") {
      event.stopPropagation();
      return;
    } else return;
    event.preventDefault();
    event.stopPropagation();
  });
  menu.addEventListener("focusout", ({ relatedTarget }) => {
    if (!menu.contains(/** @type {Node | null} */ (relatedTarget))) close();
  });
};

/** @param {HTMLElement} row @param {Line} line */
const openFor = (row, line) =>
  open(row.querySelector(".more") ?? row, line.name, choices(line));

document.body.addEventListener("click", ({ target }) => {
  const row = elementAt(target);
  const line = lineOf(row);
  if (!row || !line) return;
  if (/** @type {Element} */ (target).closest(".more")) openFor(row, line);
  else send({ do: "look", line: line.line });
});

document.body.addEventListener("contextmenu", (event) => {
  const row = elementAt(event.target);
  const line = lineOf(row);
  if (!row || !line) return;
  event.preventDefault();
  openFor(row, line);
});

document.body.addEventListener("keydown", (event) => {
  const row = elementAt(event.target);
  const line = lineOf(row);
  // Buttons in it are pressed as any.
  if (!row || !line || event.target !== row) return;
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (["Enter", "ArrowDown", "ContextMenu"].includes(event.key)) openFor(row, line);
  else if (event.key === " ") send({ do: "look", line: line.line });
  else if (event.key === "F2") rename(line);
  else if (event.key === "Delete" && !line.live) remove(line);
  else return;
  event.preventDefault();
  event.stopPropagation();
});

// --- Marks -----------------------------------------------------------------------------------------

/** @param {number} number */
const unmark = (number) => send({ do: "unmark", number });

document.body.addEventListener("click", ({ target }) => {
  const mark = /** @type {HTMLElement | null} */ (
    /** @type {Element} */ (target).closest(".mark.note")
  );
  const note = state.bar?.notes.find(({ number }) => `${number}` === mark?.dataset.note);
  if (!mark || !note) return;
  open(mark.querySelector("b") ?? mark, note.text, [
    ["Look at it", () => send({ do: "seek", step: note.step })],
    ...(state.bar?.recorded
      ? []
      : /** @type {Array<[string, () => unknown]>} */ ([
          ["Remove the mark", () => unmark(note.number)],
        ])),
  ]);
});

document.body.addEventListener("keydown", (event) => {
  const sign = /** @type {HTMLElement | null} */ (
    /** @type {Element} */ (event.target).closest('.event[data-kind="mark"]')
  );
  const note = state.bar?.notes.find(({ step }) => `${step}` === sign?.dataset.step);
  if (!note || !["Delete", "Backspace"].includes(event.key)) return;
  event.preventDefault();
  event.stopPropagation();
  unmark(note.number);
});
