// @ts-check
// Runs side by side are a page of their own in a frame, which stands in the place of all that is said
// of the one board. The lab decides whether it is there; the panel that steers the live run is not.

import { whenChanged } from "./changes.js";
import { listenTo } from "./frame.js";
import { press, whenSideKey } from "./keys.js";

/** What has nothing to do with the live run: layers, this list, and the way back. */
const OTHERS = /^(Digit\d|KeyH|KeyC)$/;
const root = document.documentElement;
/** @type {WeakSet<Element>} */
const met = new WeakSet();

const frame = () => /** @type {HTMLIFrameElement | null} */ (document.querySelector("iframe.pounce-side"));

/** @param {HTMLIFrameElement} node */
const dress = (node) => {
  const begin = () => {
    if (node.contentWindow) listenTo(node.contentWindow);
    // Its keys act at once, and a reader of the screen begins there.
    node.focus();
  };
  node.addEventListener("load", begin);
  // Its page may have come before it was met here.
  const page = node.contentDocument;
  if (page?.readyState === "complete" && page.URL !== "about:blank") begin();
};

/**
 * Keys that are pressed here act there.
 * @param {string} name
 */
const pressInFrame = (name) => {
  const within = /** @type {any} */ (frame()?.contentWindow);
  if (!within || OTHERS.test(name)) return false;
  within.dispatchEvent(new within.CustomEvent("pounce-key", { detail: name }));
  return true;
};

// Escape closes what is open first, and ends a presentation.
window.addEventListener("keydown", ({ key }) => {
  const over = [...document.querySelectorAll("[role=dialog], [role=listbox]")];
  const isOver = over.some((node) => node.checkVisibility()) || root.dataset.present !== undefined;
  if (key === "Escape" && frame() && !isOver) press("KeyC");
}, true);

whenSideKey(pressInFrame);
whenChanged(() => {
  const node = frame();
  root.toggleAttribute("data-side", node !== null);
  if (!node || met.has(node)) return;
  met.add(node);
  dress(node);
});
