// @ts-check
// Names for what viser leaves nameless.

import { whenChanged } from "./changes.js";

/** Buttons that are but a picture, by that. */
const PICTURES = {
  "list-search": "Commands",
};

/**
 * @param {Element | null | undefined} node
 * @param {Record<string, string | null | undefined>} attributes
 */
const set = (node, attributes) => {
  for (const [name, value] of Object.entries(attributes))
    if (node && value && node.getAttribute(name) !== value) node.setAttribute(name, value);
};

whenChanged(() => {
  for (const label of document.querySelectorAll("label[for]")) {
    const row = label.closest(".mantine-Flex-root");
    const name = label.textContent?.trim();
    for (const part of row?.querySelectorAll(".mantine-TextInput-input, [role=slider]") ?? [])
      set(part, { "aria-label": name });
    const group = row?.querySelector(".mantine-Button-root")?.parentElement;
    set(group, { role: "group", "aria-label": name });
  }
  for (const [picture, name] of Object.entries(PICTURES))
    for (const icon of document.querySelectorAll(`.tabler-icon-${picture}`))
      set(icon.closest("button"), { "aria-label": name });
  const board = document.querySelector("[data-board]")?.getAttribute("data-board");
  set(document.querySelector("canvas[data-engine]"), { role: "img", "aria-label": board });
});
