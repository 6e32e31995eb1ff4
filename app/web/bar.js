// @ts-check
// A click on a block of the bar chooses it, and shows where it is changed.

import { showTab } from "./docks.js";

document.addEventListener("click", ({ target }) => {
  if (target instanceof Element && target.closest(".pounce-bar a.piece")) showTab("Plan");
});
