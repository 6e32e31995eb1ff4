// @ts-check
// Keys act by their place on the keyboard, whatever letters it has, and move no camera.
//
// viser's commands go by the character that a key types, and its camera by the places of W A S D Q
// E. So what types a character is kept from viser, and where it is a key of the lab's, viser is told
// of the character that the command is registered with, without a place.

import { whenChanged } from "./changes.js";

/**
 * `name` is its place, with "Shift+" before it if it takes that.
 * @typedef {{name: string, character: string, repeats: boolean, ofTime: boolean}} Key
 */

const SWITCH = "pounce-single-keys";
/** @type {Map<string, Key>} */
const keys = new Map();
/** What this keyboard has at a place, as far as it is known, by the names of keys. @type {Map<string, string>} */
const letters = new Map();
const told = new WeakSet();
/** What is done here, without the lab. @type {Map<string, () => void>} */
const local = new Map();
/** Where keys of time go. @type {(name: string) => void} */
let tellTime = () => {};
/** Where keys go while runs stand side by side; whether one is done there. @type {(name: string) => boolean} */
let tellSide = () => false;
let isTabbed = false;
/** Whether a pointer is down, and whether one was used since the focus was last given by other means. */
let isPointing = false;
let isClicked = false;

/**
 * In a lesson only those keys act that are of its controls.
 * @param {string} name
 */
const isOfLesson = (name) => {
  const { lessonKeys } = document.documentElement.dataset;
  return lessonKeys?.split(" ").includes(name) ?? true;
};
/** What opens viser's list of all commands, with control or its like. */
const OPENS_COMMANDS = ["KeyK", "KeyP"];

const areOn = () => localStorage.getItem(SWITCH) !== "off";

/**
 * Digits are written on all keyboards, even where they take shift.
 * @param {string} name
 * @param {string} character
 */
const learn = (name, character) => {
  const letter = character.toUpperCase();
  const isLetter = /^(Shift\+)?(Key|Bracket|Comma|Period)/.test(name) && [...character].length === 1;
  if (!isLetter || letters.get(name) === letter) return;
  letters.set(name, letter);
  fillList();
};

/** @param {HTMLElement | null} target */
const takesText = (target) =>
  target?.isContentEditable ||
  target?.matches("textarea, select, input:not([type=checkbox], [type=radio], [type=file])");

/**
 * Whether space is meant for what has the focus, which it is not for what was only clicked.
 * @param {HTMLElement | null} target
 */
const takesSpace = (target) =>
  (isTabbed || target?.closest("[role=dialog]")) &&
  target?.matches("a, button, input, summary, [role=button], [role=tab]");

/**
 * Whether what has the focus has a beginning and an end of its own that are meant, which those of
 * what was only clicked are not.
 * @param {HTMLElement | null} target
 */
const takesEnds = (target) =>
  target?.closest("[role=listbox], [role=menu], [role=dialog]") ||
  (!isClicked && target?.closest("[role=slider], [role=tablist]"));

/**
 * @param {KeyboardEvent} event
 * @returns {Key | undefined}
 */
const keyOf = ({ code, key, shiftKey }) => {
  // Wherever it is, with shift or without.
  if (key === "?") return keys.get("KeyH");
  const [, row, digit] = /^(Digit|Numpad)(\d)$/.exec(code) ?? [];
  if (row && (row === "Numpad" || shiftKey))
    return key === digit ? keys.get(`Digit${digit}`) : undefined;
  if (code) return keys.get(shiftKey ? `Shift+${code}` : code);
  // Keyboards on a screen may tell of no place.
  return [...keys.values()].find(({ character }) => character === key.toLowerCase());
};

/** @param {string} character */
const tellViser = (character) => {
  const event = new KeyboardEvent("keydown", { key: character, bubbles: true });
  told.add(event);
  document.documentElement.dispatchEvent(event);
};

/**
 * Have a key act in this browser alone.
 * @param {string} code
 * @param {() => void} act
 */
export const onKey = (code, act) => void local.set(code, act);

/**
 * Have the names of keys of time sent to where these act.
 * @param {(name: string) => void} tell
 */
export const whenTimeKey = (tell) => void (tellTime = tell);

/**
 * Have the names of keys sent to the runs that stand side by side, which say whether they took it.
 * @param {(name: string) => boolean} tell
 */
export const whenSideKey = (tell) => void (tellSide = tell);

/**
 * Do what a key does.
 * @param {string} name
 */
export const press = (name) => {
  if (!isOfLesson(name)) return;
  const key = keys.get(name);
  const act = local.get(name);
  if (act) act();
  else if (tellSide(name)) return;
  else if (key?.ofTime) {
    // What is open over the page keeps the focus, which a mark would take.
    const dialogs = [...document.querySelectorAll("[role=dialog]")];
    if (!dialogs.some((dialog) => dialog.checkVisibility())) tellTime(name);
  }
  else if (key) tellViser(key.character);
};

/** @param {KeyboardEvent} event */
const take = (event) => {
  if (told.has(event)) return;
  if (event.key === "Tab") isTabbed = true;
  const { lessonKeys } = document.documentElement.dataset;
  if (lessonKeys !== undefined && (event.ctrlKey || event.metaKey) && OPENS_COMMANDS.includes(event.code))
    event.stopImmediatePropagation();
  if (event.ctrlKey || event.metaKey || event.altKey || event.getModifierState("AltGraph")) return;
  const target = event.target instanceof HTMLElement ? event.target : null;
  if (event.isComposing || takesText(target)) return;
  if (event.key === "Escape" && target?.matches("input")) return tellViser(event.key);
  const key = keyOf(event);
  const typesCharacter = [...event.key].length === 1 || event.key === "Dead";
  if (!key && !typesCharacter) return;
  if (event.key === " " && takesSpace(target)) return;
  if (!typesCharacter && (takesEnds(target) || !areOn())) return;
  event.stopImmediatePropagation();
  if (typesCharacter) learn(`${event.shiftKey ? "Shift+" : ""}${event.code}`, event.key);
  if (!key) return;
  event.preventDefault();
  if (areOn() && (key.repeats || !event.repeat)) press(key.name);
};

/** The list of keys says what is on this keyboard, and whether keys act at all. */
const fillList = () => {
  const table = document.querySelector("[data-keys]")?.getAttribute("data-keys");
  if (table && keys.size === 0)
    for (const key of JSON.parse(table)) keys.set(key.name, key);
  document.documentElement.toggleAttribute("data-has-keys", keys.size > 0);
  for (const shown of document.querySelectorAll("kbd[data-code]")) {
    const letter = letters.get(shown.getAttribute("data-code") ?? "");
    if (letter && shown.textContent !== letter) shown.textContent = letter;
  }
  for (const box of document.querySelectorAll(`input.${SWITCH}`))
    if (box instanceof HTMLInputElement) box.checked = areOn();
};

window.addEventListener("keydown", take, true);
window.addEventListener("pointerdown", () => (isTabbed = false), true);
// A finger's press gives the focus after it is up, as a mouse's.
for (const kind of ["pointerdown", "mousedown"])
  window.addEventListener(kind, () => (isPointing = isClicked = true), true);
for (const kind of ["pointerup", "pointercancel", "mouseup"])
  window.addEventListener(kind, () => (isPointing = false), true);
window.addEventListener("focusin", () => (isClicked = isPointing), true);
document.body.addEventListener("keydown", (event) => {
  // What arrows move is a slider, or a tab, and never the camera.
  if (event.key.startsWith("Arrow")) event.stopPropagation();
});
document.addEventListener("click", ({ target }) => {
  const button = target instanceof Element ? target.closest("[data-press]") : null;
  if (button) press(button.getAttribute("data-press") ?? "");
});
// Who has chosen from a list with a pointer is done with it: what is typed then is no search in it.
document.addEventListener("click", ({ target, detail }) => {
  if (!detail || !(target instanceof Element) || !target.closest("[role=option]")) return;
  setTimeout(() => {
    const field = document.activeElement;
    if (field instanceof HTMLInputElement && field.matches("[aria-haspopup=listbox]")) field.blur();
  });
});
document.addEventListener("change", ({ target }) => {
  if (target instanceof HTMLInputElement && target.classList.contains(SWITCH))
    localStorage.setItem(SWITCH, target.checked ? "on" : "off");
});
whenChanged(fillList);
// Few browsers tell, and only pages that nobody can have changed on their way.
/** @type {any} */ (navigator).keyboard
  ?.getLayoutMap()
  .then((/** @type {Iterable<[string, string]>} */ map) => {
    for (const [code, letter] of map) learn(code, letter);
  });
