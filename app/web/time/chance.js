// @ts-check
// A probability that is edited where it stands: a small field over the block.

/**
 * @typedef {{
 *   show: (chance: number) => void,
 *   take: () => void,
 *   giveUp: () => void,
 *   close: () => void,
 * }} Taker
 */

const MARGIN_PX = 2;

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
  const field = document.createElement("input");
  field.className = "chance-field";
  field.setAttribute("aria-label", label);
  field.inputMode = "decimal";
  field.value = percent(chance);
  document.body.append(field);
  const box = place.getBoundingClientRect();
  const { width, height } = field.getBoundingClientRect();
  const left = box.left + box.width / 2 - width / 2;
  const most = document.body.clientWidth - width - MARGIN_PX;
  field.style.left = `${Math.min(Math.max(left, MARGIN_PX), most)}px`;
  field.style.top = `${Math.max(box.top + box.height / 2 - height / 2, 0)}px`;
  field.focus();
  field.select();
  let isOpen = true;

  /** @param {boolean} isTaken */
  const close = (isTaken) => {
    if (!isOpen) return;
    isOpen = false;
    const hadFocus = document.activeElement === field;
    field.remove();
    if (isTaken) taker.take();
    else taker.giveUp();
    if (hadFocus) taker.close();
  };

  const judge = () => {
    const typed = chanceIn(field.value);
    field.toggleAttribute("aria-invalid", typed === null);
    if (typed !== null) taker.show(typed);
    return typed;
  };

  field.addEventListener("input", judge);
  field.addEventListener("keydown", (event) => {
    event.stopPropagation();
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
