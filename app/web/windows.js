// @ts-check
// In a small window the schedule lies over the ends of both side panels: there it begins folded.

import { whenChanged } from "./changes.js";

const small = matchMedia("(max-width: 1199px), (max-height: 639px)");
let isSeenTo = false;

const fold = () => {
  if (isSeenTo) return;
  const handle = document.querySelector(
    "[data-floating-window]:has(.pounce-planner) [data-dock-minimize][aria-expanded=true]",
  );
  if (!(handle instanceof HTMLElement)) return;
  isSeenTo = true;
  if (small.matches) handle.click();
};

whenChanged(fold);
// The browser's zoom makes it smaller, too.
small.addEventListener("change", () => {
  isSeenTo = !small.matches;
  fold();
});
