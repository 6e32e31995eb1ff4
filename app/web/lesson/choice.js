// @ts-check
// One of several, by radio buttons.

import { put } from "../player/html.js";
import { element } from "../time/dom.js";

/** @type {import("./ask.js").Maker} */
export const choice = ({ options }, give) => {
  const node = element("div", "choices");
  const boxes = options.map(([value, html]) => {
    const label = element("label", "choice");
    const box = document.createElement("input");
    box.type = "radio";
    box.name = "choice";
    box.value = value;
    box.addEventListener("change", () => give(value));
    const words = element("span", "");
    put(words, html);
    label.append(box, words);
    node.append(label);
    return box;
  });
  return {
    node,
    show: (answer) => {
      for (const box of boxes) box.checked = box.value === answer;
    },
  };
};
