// @ts-check
// A tab opens by itself where the lab says so: `data-open-tab` names it, and a number in `data-times`
// counts how often. Only a number that has grown counts, for a page that loads shows what it shows.

import { whenChanged } from "./changes.js";

/** The last number of each tab. @type {Map<string, number>} */
const seen = new Map();

/** @param {string} name */
const open = (name) => {
  for (const tab of document.querySelectorAll("[role=tab]")) {
    if (tab.textContent?.trim() !== name || tab.getAttribute("aria-selected") === "true") continue;
    // viser's tabs take a press for the beginning of a drag, but obey keys.
    tab.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", bubbles: true }));
  }
};

whenChanged(() => {
  for (const nudge of document.querySelectorAll("[data-open-tab]")) {
    const name = nudge.getAttribute("data-open-tab") ?? "";
    const times = Number(nudge.getAttribute("data-times"));
    const before = seen.get(name) ?? times;
    seen.set(name, times);
    if (times > before) open(name);
  }
});
