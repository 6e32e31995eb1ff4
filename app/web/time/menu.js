// @ts-check
// What can be done with a line of the tree: its menu, and its name, which is edited in place.

import { send } from "./channel.js";
import { say } from "./said.js";
import { state } from "./state.js";

/** @typedef {import("./state.js").Line} Line */

const MOST_CHARACTERS = 80;
const MARGIN_PX = 2;

/** @param {EventTarget | null} target */
const elementAt = (target) =>
  /** @type {HTMLElement | null} */ (/** @type {Element | null} */ (target)?.closest(".line") ?? null);

/** @param {HTMLElement | null} element */
const lineOf = (element) => state.bar?.lines.find(({ line }) => `${line}` === element?.dataset.line);

/** @param {Line} line */
const elementOf = ({ line }) =>
  /** @type {HTMLElement | null} */ (document.querySelector(`.line[data-line="${line}"]`));

// --- Its name --------------------------------------------------------------------------------------

/** @param {Line} line */
const rename = (line) => {
  const element = elementOf(line);
  const shown = element?.querySelector(".name") ?? element;
  if (!element || !shown) return;
  const field = document.createElement("input");
  field.className = "name-field";
  field.maxLength = MOST_CHARACTERS;
  field.value = line.name;
  field.setAttribute("aria-label", `Name of ${line.name}`);
  document.body.append(field);
  const box = shown.getBoundingClientRect();
  field.style.left = `${Math.max(Math.min(box.left, document.body.clientWidth - field.offsetWidth - MARGIN_PX), MARGIN_PX)}px`;
  field.style.top = `${Math.max(box.top + box.height / 2 - field.offsetHeight / 2, 0)}px`;
  field.focus();
  field.select();
  let isOpen = true;
  /** @param {boolean} isTaken */
  const close = (isTaken) => {
    if (!isOpen) return;
    isOpen = false;
    const name = field.value.trim();
    const hadFocus = document.activeElement === field;
    field.remove();
    if (isTaken && name && name !== line.name) send({ do: "name", line: line.line, name });
    if (hadFocus) elementOf(line)?.focus({ preventScroll: true });
  };
  field.addEventListener("keydown", (event) => {
    event.stopPropagation();
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
 * @param {HTMLElement} element
 * @param {Line} line
 */
const open = (element, line) => {
  close();
  const menu = document.createElement("div");
  menu.className = "line-menu";
  menu.setAttribute("role", "menu");
  menu.setAttribute("aria-label", line.name);
  const items = choices(line).map(([label, act]) => {
    const item = document.createElement("button");
    item.type = "button";
    item.tabIndex = -1;
    item.setAttribute("role", "menuitem");
    item.textContent = label;
    item.addEventListener("click", () => {
      close();
      act();
    });
    return item;
  });
  menu.append(...items);
  document.body.append(menu);
  const box = (element.querySelector(".more") ?? element).getBoundingClientRect();
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
    if (hadFocus) elementOf(line)?.focus({ preventScroll: true });
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

document.body.addEventListener("click", ({ target }) => {
  const element = elementAt(target);
  const line = lineOf(element);
  if (!element || !line) return;
  if (/** @type {Element} */ (target).closest(".more")) open(element, line);
  else send({ do: "look", line: line.line });
});

document.body.addEventListener("contextmenu", (event) => {
  const element = elementAt(event.target);
  const line = lineOf(element);
  if (!element || !line) return;
  event.preventDefault();
  open(element, line);
});

document.body.addEventListener("keydown", (event) => {
  const element = elementAt(event.target);
  const line = lineOf(element);
  // Buttons in it are pressed as any.
  if (!element || !line || event.target !== element) return;
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === "Enter" || event.key === "ArrowDown" || event.key === "ContextMenu")
    open(element, line);
  else if (event.key === " ") send({ do: "look", line: line.line });
  else if (event.key === "F2") rename(line);
  else if (event.key === "Delete" && !line.live) remove(line);
  else return;
  event.preventDefault();
  event.stopPropagation();
});
