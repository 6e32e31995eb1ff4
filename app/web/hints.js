// @ts-check
// Hints: what viser does not show of buttons, and shows over other fields.

import { whenChanged } from "./changes.js";

const GAP_PX = 8;

/**
 * A hint stands beside the panel of what it is about, and covers no other field.
 * @param {Element} hint
 */
const place = (hint) => {
  if (!(hint instanceof HTMLElement)) return;
  const about = document.querySelector(`[aria-describedby~="${CSS.escape(hint.id)}"]`);
  const panel = about?.closest("[data-dock-region]");
  if (about && panel) {
    hint.style.translate = "none";
    const [from, row, edge] = [hint, about, panel].map((node) => node.getBoundingClientRect());
    const isLeft = panel.getAttribute("data-dock-region") === "left";
    const x = isLeft ? edge.right + GAP_PX - from.left : edge.left - GAP_PX - from.right;
    const y = (row.top + row.bottom - from.top - from.bottom) / 2;
    hint.style.translate = `${x}px ${y}px`;
  }
  hint.dataset.placed = "";
};

whenChanged(() => {
  for (const hint of document.querySelectorAll(".mantine-Tooltip-tooltip")) place(hint);
  for (const hint of document.querySelectorAll("[data-hint-of]")) {
    const button = document.getElementById(hint.getAttribute("data-hint-of") ?? "");
    if (button && button.title !== hint.textContent) button.title = hint.textContent ?? "";
  }
  // That a file has come says nothing of whether it can be used, which the lab says.
  for (const body of document.querySelectorAll(".mantine-Notification-description"))
    if (body.textContent === "File uploaded successfully.") {
      const notice = body.closest(".mantine-Notification-root");
      if (notice instanceof HTMLElement) notice.style.display = "none";
    }
});
