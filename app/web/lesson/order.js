// @ts-check
// Things that are put in order: by buttons, or by the arrows of the one that has the focus.

import { put } from "../player/html.js";
import { attribute, element } from "../time/dom.js";
import { word } from "./words.js";

/** @type {import("./ask.js").Maker} */
export const order = ({ options }, give) => {
  const node = element("div", "order");
  node.append(element("p", "where", word("putInOrder")));
  const list = document.createElement("ol");
  node.append(list);
  let now = options.map(([value]) => value);

  /** @param {string} value @param {1 | -1} by */
  const move = (value, by) => {
    const from = now.indexOf(value);
    const to = from + by;
    if (to < 0 || to >= now.length) return;
    now = [...now];
    now.splice(from, 1);
    now.splice(to, 0, value);
    give(now);
    place();
  };

  /** @param {string} value @param {string} name @param {1 | -1} by */
  const arrow = (value, name, by) => {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = by < 0 ? "▲" : "▼";
    button.ariaLabel = word(by < 0 ? "up" : "down", name);
    button.addEventListener("click", () => {
      move(value, by);
      button.focus();
    });
    return button;
  };

  const items = new Map(
    options.map(([value, html]) => {
      const item = element("li", "");
      const words = element("span", "");
      put(words, html);
      const name = words.textContent ?? "";
      item.append(words, arrow(value, name, -1), arrow(value, name, 1));
      item.addEventListener("keydown", (event) => {
        const by = { ArrowUp: -1, ArrowDown: 1 }[event.key];
        if (!by) return;
        event.preventDefault();
        const had = /** @type {HTMLElement | null} */ (document.activeElement);
        move(value, /** @type {1 | -1} */ (by));
        had?.focus();
      });
      return [value, item];
    }),
  );

  const place = () => {
    now.forEach((value, at) => {
      const item = items.get(value);
      if (!item) return;
      if (list.children[at] !== item) list.insertBefore(item, list.children[at] ?? null);
      const [up, down] = /** @type {NodeListOf<HTMLButtonElement>} */ (item.querySelectorAll("button"));
      // One that cannot be pressed keeps the focus that it has.
      attribute(up, "aria-disabled", at === 0 ? "true" : null);
      attribute(down, "aria-disabled", at === now.length - 1 ? "true" : null);
    });
  };
  place();
  return {
    node,
    show: (answer) => {
      if (!answer || JSON.stringify(answer) === JSON.stringify(now)) return;
      now = answer;
      place();
    },
  };
};
