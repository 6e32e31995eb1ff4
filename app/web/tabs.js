// @ts-check
// A tab opens by itself where the lab says so: `data-open-tab` names it, and a number in `data-times`
// counts how often. Only a number that has grown counts, for a page that loads shows what it shows.

import { whenChanged } from "./changes.js";
import { showTab } from "./docks.js";

/** The last number of each tab. @type {Map<string, number>} */
const seen = new Map();

whenChanged(() => {
  for (const nudge of document.querySelectorAll("[data-open-tab]")) {
    const name = nudge.getAttribute("data-open-tab") ?? "";
    const times = Number(nudge.getAttribute("data-times"));
    const before = seen.get(name) ?? times;
    seen.set(name, times);
    if (times > before) showTab(name);
  }
});
