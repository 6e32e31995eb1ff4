// @ts-check
// In a small window the schedule lies over the ends of both side panels: there it begins folded.

import { whenChanged } from "./changes.js";

const small = matchMedia("(max-width: 1199px), (max-height: 639px)");
/** Until the schedule is there. */
let isToFold = small.matches;

const fold = () => {
  const handle = document.querySelector(
    "[data-floating-window]:has(.pounce-schedule) [data-dock-minimize][aria-expanded=true]",
  );
  if (!isToFold || !(handle instanceof HTMLElement)) return;
  isToFold = false;
  handle.click();
};

whenChanged(fold);
// The browser's zoom makes a window smaller, too.
small.addEventListener("change", () => {
  isToFold = small.matches;
  fold();
  // Where it is folded already, whoever opens it wants it open.
  isToFold = false;
});
