// @ts-check
// A curve that is drawn on the time bar with six handles, or typed as six numbers.

import { element } from "../time/dom.js";
import { numeral, word } from "./words.js";

const HANDLES = 6;

/** The trials of the handles. @param {number} first @param {number} last */
const trialsOf = (first, last) =>
  Array.from({ length: HANDLES }, (_, at) => Math.round(first + ((last - first) * at) / (HANDLES - 1)));

/** @type {import("./ask.js").Maker} */
export const sketch = ({ from, to, low, high }, give) => {
  const node = element("div", "sketch");
  node.append(element("p", "where", word("drawOn")));
  const typed = document.createElement("details");
  typed.append(element("summary", "", word("typeIt")));
  node.append(typed);
  let trials = trialsOf(from ?? 0, to ?? 1);
  /** @type {Array<number | null>} */
  let rewards = trials.map(() => null);
  const labels = trials.map((trial, at) => {
    const label = element("label", "typed");
    const field = document.createElement("input");
    field.type = "number";
    field.step = "1";
    field.min = `${low ?? -60}`;
    field.max = `${high ?? 100}`;
    field.autocomplete = "off";
    const words = element("span", "", word("rewardAt", numeral(trial)));
    label.append(words, field);
    field.addEventListener("change", () => {
      const value = field.valueAsNumber;
      if (!Number.isFinite(value)) return;
      const within = Math.min(Math.max(value, Number(field.min)), Number(field.max));
      // What has not been typed is as it is beside it.
      const all = rewards.map((reward, other) => (other === at ? within : reward ?? within));
      rewards = all;
      give(trials.map((trial, other) => [trial, all[other]]));
    });
    typed.append(label);
    return { words, field };
  });
  return {
    node,
    show: (answer) => {
      if (!answer) return;
      trials = answer.map((/** @type {[number, number]} */ [trial]) => trial);
      rewards = answer.map((/** @type {[number, number]} */ [, reward]) => reward);
      labels.forEach(({ words, field }, at) => {
        words.textContent = word("rewardAt", numeral(trials[at]));
        const text = rewards[at] === null ? "" : `${Math.round(rewards[at] ?? 0)}`;
        if (document.activeElement !== field && field.value !== text) field.value = text;
      });
    },
  };
};
