// @ts-check
// A probability that is edited where it stands: a small field over the block.

import { openField } from "./field.js";

/**
 * @typedef {{
 *   show: (chance: number) => void,
 *   take: () => void,
 *   giveUp: () => void,
 *   close: () => void,
 * }} Taker
 */

/**
 * What somebody has typed as a share: percents, or a number below 1; null if it is none.
 * @param {string} text
 */
const chanceIn = (text) => {
  const [, number, sign] = /^\s*(\d+(?:[.,]\d*)?|[.,]\d+)\s*(%?)\s*$/.exec(text) ?? [];
  if (number === undefined) return null;
  const value = Number(number.replace(",", "."));
  const chance = sign || value >= 1 ? value / 100 : value;
  return chance <= 1 ? chance : null;
};

/** @param {number} chance */
const percent = (chance) => `${Number((100 * chance).toFixed(2))} %`;

/**
 * Open a field where a probability is shown; it closes when it is finished or given up.
 * @param {Element} place
 * @param {string} label
 * @param {number} chance
 * @param {Taker} taker
 */
export const openChance = (place, label, chance, taker) => {
  document.querySelector(".chance-field")?.remove();
  const { field, close } = openField(place, {
    name: "chance-field",
    label,
    value: percent(chance),
    isCentred: true,
    end: (isTaken) => (isTaken ? taker.take() : taker.giveUp()),
    goBack: taker.close,
  });
  field.inputMode = "decimal";

  const judge = () => {
    const typed = chanceIn(field.value);
    field.toggleAttribute("aria-invalid", typed === null);
    if (typed !== null) taker.show(typed);
    return typed;
  };

  field.addEventListener("input", judge);
  field.addEventListener("keydown", (event) => {
    if (event.key === "Escape") {
      event.preventDefault();
      return close(false);
    }
    if (event.key === "Enter") {
      event.preventDefault();
      if (judge() !== null) close(true);
      return;
    }
    const by = { ArrowUp: 0.01, ArrowDown: -0.01 }[event.key];
    if (!by) return;
    event.preventDefault();
    const next = (chanceIn(field.value) ?? chance) + by * (event.shiftKey ? 10 : 1);
    field.value = percent(Math.min(Math.max(next, 0), 1));
    judge();
  });
  // What is no number is not taken from somebody who has gone on to something else.
  field.addEventListener("blur", () => close(judge() !== null));
};
