// @ts-check
// A number, in a field and by a slider; and a moment, which is clicked on the time bar, or typed.

import { element } from "../time/dom.js";
import { numeral, word } from "./words.js";

/** A slider has so many steps, or fewer. */
const STEPS = 200;
const ROUND = [1, 2, 5, 10, 20, 25, 50, 100, 200, 250, 500, 1_000, 2_000, 5_000];

/**
 * @param {HTMLInputElement} field
 * @param {number | null} low
 * @param {number | null} high
 * @returns {number | null} what is typed there, within bounds
 */
const typed = (field, low, high) => {
  const value = field.valueAsNumber;
  if (!Number.isFinite(value)) return null;
  return Math.min(Math.max(value, low ?? -Infinity), high ?? Infinity);
};

/**
 * @param {string} label
 * @param {number | null} low
 * @param {number | null} high
 */
const numberField = (label, low, high) => {
  const field = document.createElement("input");
  field.type = "number";
  field.inputMode = "decimal";
  field.step = "any";
  field.autocomplete = "off";
  field.ariaLabel = label;
  if (low !== null) field.min = `${low}`;
  if (high !== null) field.max = `${high}`;
  return field;
};

/** What somebody types, or drags, is theirs. @param {HTMLInputElement} field @param {number | null} value */
const write = (field, value) => {
  const text = value === null ? "" : `${value}`;
  if (document.activeElement !== field && field.value !== text) field.value = text;
};

/** @type {import("./ask.js").Maker} */
export const number = ({ low, high, unit }, give) => {
  const node = element("div", "number");
  const label = unit ? `${word("yourNumber")}, ${unit}` : word("yourNumber");
  const row = element("div", "typed");
  const field = numberField(label, low, high);
  row.append(field, element("span", "unit", unit ?? ""));
  node.append(row);
  field.addEventListener("input", () => {
    const value = typed(field, low, high);
    if (value !== null) give(value, true);
  });
  field.addEventListener("change", () => {
    const value = typed(field, low, high);
    if (value === null) return;
    field.value = `${value}`;
    give(value);
  });
  if (low === null || high === null) return { node, show: (answer) => write(field, answer) };
  const slider = document.createElement("input");
  slider.type = "range";
  slider.min = `${low}`;
  slider.max = `${high}`;
  const step = ROUND.find((size) => (high - low) / size <= STEPS) ?? (high - low) / STEPS;
  slider.step = high - low < 10 ? "any" : `${step}`;
  slider.ariaLabel = label;
  slider.addEventListener("input", () => {
    field.value = `${slider.valueAsNumber}`;
    give(slider.valueAsNumber, true);
  });
  slider.addEventListener("change", () => give(slider.valueAsNumber));
  const ends = element("div", "ends");
  ends.ariaHidden = "true";
  ends.append(element("span", "", numeral(low, 2)), element("span", "", numeral(high, 2)));
  node.append(slider, ends);
  return {
    node,
    show: (answer) => {
      if (document.activeElement !== slider) write(field, answer);
      node.classList.toggle("unset", answer === null);
      write(slider, answer ?? (low + high) / 2);
      slider.setAttribute("aria-valuetext", answer === null ? word("none") : numeral(answer, 2));
    },
  };
};

/** @type {import("./ask.js").Maker} */
export const moment = ({ from, to }, give) => {
  const node = element("div", "moment");
  node.append(element("p", "where", word("onBar")));
  const label = element("label", "typed");
  const field = numberField(word("trial"), from ?? 0, to);
  field.step = "1";
  label.append(element("span", "", word("orType")), field);
  node.append(label);
  field.addEventListener("change", () => {
    const value = typed(field, from ?? 0, to);
    if (value !== null) give(Math.round(value));
  });
  return { node, show: (answer) => write(field, answer) };
};
