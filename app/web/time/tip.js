// @ts-check
// Hints for those who use no mouse: what has the focus by keyboard, or was touched, says what it is, at
// once; the browser's own hints come late, and only to a pointer.

const GAP_PX = 6;

const tip = document.createElement("div");
tip.id = "tip";
tip.ariaHidden = "true";
tip.hidden = true;
document.body.append(tip);

/** @param {Element} part */
const show = (part) => {
  tip.textContent = part.getAttribute("title");
  tip.hidden = false;
  const { left, right, top, bottom } = part.getBoundingClientRect();
  const { width, height } = tip.getBoundingClientRect();
  const x = Math.min(Math.max((left + right - width) / 2, GAP_PX), innerWidth - width - GAP_PX);
  // It stands within the frame, and not on what it is said of, where that has room.
  const above = top - height - GAP_PX;
  const below = Math.min(bottom + GAP_PX, innerHeight - height);
  tip.style.left = `${Math.max(x, 0)}px`;
  tip.style.top = `${above >= 0 ? above : Math.max(below, 0)}px`;
};
const hide = () => void (tip.hidden = true);

/** What has the focus again because something was done has been read before, and says what was. */
let isAnswered = false;

document.addEventListener("focusin", ({ target }) => {
  const part = target instanceof Element ? target.closest("[title]") : null;
  if (part && part.matches(":focus-visible") && !isAnswered) show(part);
  else hide();
});
document.addEventListener("focusout", hide);
document.addEventListener("pointerdown", () => {
  isAnswered = false;
  hide();
});
document.addEventListener("pointerup", ({ target, pointerType }) => {
  const part = target instanceof Element ? target.closest("[title]") : null;
  if (part && pointerType === "touch") show(part);
});
window.addEventListener(
  "keydown",
  ({ key }) => {
    isAnswered = ["Enter", "Escape", " "].includes(key);
    hide();
  },
  { capture: true },
);
