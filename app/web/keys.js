// @ts-check
// Keys act by their place on the keyboard, whatever letters it has, and move no camera.
//
// viser's commands go by the character that a key types, and its camera by the places of W A S D Q
// E. So what types a character is kept from viser, and where it is a key of the lab's, viser is told
// of the character that the command is registered with, without a place.

import { whenChanged } from "./changes.js";

/** @typedef {{code: string, character: string, repeats: boolean}} Key */

const SWITCH = "pounce-single-keys";
/** @type {Map<string, Key>} */
const keys = new Map();
/** What this keyboard has at a place, as far as it is known. @type {Map<string, string>} */
const letters = new Map();
const told = new WeakSet();
/** What is done here, without the lab. @type {Map<string, () => void>} */
const local = new Map();
let isTabbed = false;

const areOn = () => localStorage.getItem(SWITCH) !== "off";

/**
 * Digits are written on all keyboards, even where they take shift.
 * @param {string} code
 * @param {string} character
 */
const learn = (code, character) => {
  if (code.startsWith("Key") && character.length === 1) letters.set(code, character.toUpperCase());
};

/** @param {EventTarget | null} target */
const takesText = (target) =>
  target instanceof HTMLElement &&
  (target.isContentEditable ||
    target.matches("textarea, select, input:not([type=checkbox], [type=radio], [type=file])"));

/**
 * Whether space is meant for what has the focus, which it is not for what was only clicked.
 * @param {EventTarget | null} target
 */
const takesSpace = (target) =>
  target instanceof HTMLElement &&
  (isTabbed || target.closest("[role=dialog]") !== null) &&
  target.matches("a, button, input, summary, [role=button], [role=tab]");

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
  if (shiftKey) return undefined;
  if (code) return keys.get(code);
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
 * Do what a key does.
 * @param {string} code
 */
export const press = (code) => {
  const character = keys.get(code)?.character;
  const act = local.get(code);
  if (act) act();
  else if (character) tellViser(character);
};

/** @param {KeyboardEvent} event */
const take = (event) => {
  if (told.has(event)) return;
  if (event.key === "Tab") isTabbed = true;
  if (event.ctrlKey || event.metaKey || event.altKey || event.getModifierState("AltGraph")) return;
  if (event.isComposing || takesText(event.target)) return;
  if (event.key === "Escape" && event.target instanceof HTMLInputElement)
    return tellViser(event.key);
  const key = keyOf(event);
  const typesCharacter = [...event.key].length === 1 || event.key === "Dead";
  if (!key && !typesCharacter) return;
  if (event.key === " " && takesSpace(event.target)) return;
  event.stopImmediatePropagation();
  if (typesCharacter && !event.shiftKey) learn(event.code, event.key);
  if (!key) return;
  event.preventDefault();
  if (areOn() && (key.repeats || !event.repeat)) press(key.code);
};

/** The list of keys says what is on this keyboard, and whether keys act at all. */
const fillList = () => {
  const table = document.querySelector("[data-keys]")?.getAttribute("data-keys");
  if (table && keys.size === 0)
    for (const key of JSON.parse(table)) keys.set(key.code, key);
  for (const shown of document.querySelectorAll("kbd[data-code]")) {
    const letter = letters.get(shown.getAttribute("data-code") ?? "");
    if (letter && shown.textContent !== letter) shown.textContent = letter;
  }
  for (const box of document.querySelectorAll(`input.${SWITCH}`))
    if (box instanceof HTMLInputElement) box.checked = areOn();
};

window.addEventListener("keydown", take, true);
window.addEventListener("pointerdown", () => (isTabbed = false), true);
document.body.addEventListener("keydown", (event) => {
  // What arrows move is a slider, or a tab, and never the camera.
  if (event.key.startsWith("Arrow")) event.stopPropagation();
});
document.addEventListener("click", ({ target }) => {
  const button = target instanceof Element ? target.closest("[data-press]") : null;
  if (button) press(button.getAttribute("data-press") ?? "");
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
    fillList();
  });
