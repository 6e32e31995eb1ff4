// @ts-check
// The frame in which the time bar is a page of its own: it is as high as what is in it, keys act there
// as they do here, and where it does not come up that is said.

import { whenChanged } from "./changes.js";
import { uncoverStage } from "./docks.js";
import { whenTimeKey } from "./keys.js";

/** How long it may take until somebody is told. */
const PATIENCE_MS = 6_000;
const ABSENT =
  "The time bar does not come up in this browser. The tab Plan has fields for what one edits in it.";
/** What these keys do in the frame is meant for what has the focus there. */
const TAKES_KEYS = "input, textarea, select, [contenteditable]";
const TAKES_SPACE = "a, button, summary, [role=button], [role=tab]";
const OTHERS = ["Escape", "Home", "End"];

/** @type {WeakSet<Element>} */
const met = new WeakSet();

const frame = () => /** @type {HTMLIFrameElement | null} */ (document.querySelector("iframe.pounce-time"));

/** @param {HTMLIFrameElement} node */
const isOpen = (node) => node.contentDocument?.documentElement?.dataset.connection === "open";

/** @param {KeyboardEvent} event */
const isMeantForFrame = (event) => {
  // Elements of the frame are of no class of this page.
  const target = /** @type {HTMLElement | null} */ (event.target);
  if (event.defaultPrevented || target?.matches?.(TAKES_KEYS)) return true;
  const isSpace = event.key === " " && target?.matches?.(TAKES_SPACE);
  return isSpace && target?.matches(":focus-visible");
};

/**
 * A key that the frame has no use for does here what it does.
 * @param {KeyboardEvent} event
 */
const passOn = (event) => {
  const typesCharacter = [...event.key].length === 1;
  if (!(typesCharacter || OTHERS.includes(event.key)) || isMeantForFrame(event)) return;
  const { key, code, repeat, isComposing, shiftKey, ctrlKey, altKey, metaKey } = event;
  const modifierAltGraph = event.getModifierState("AltGraph");
  const here = new KeyboardEvent("keydown", {
    ...{ key, code, repeat, isComposing, shiftKey, ctrlKey, altKey, metaKey, modifierAltGraph },
    bubbles: true,
    cancelable: true,
  });
  if (!document.body.dispatchEvent(here)) event.preventDefault();
};

/**
 * Keys of time that are pressed here act there.
 * @param {string} name
 */
const pressInFrame = (name) => {
  const within = /** @type {any} */ (frame()?.contentWindow);
  within?.dispatchEvent(new within.CustomEvent("pounce-key", { detail: name }));
};

/**
 * Keys and presses in a frame's page that are none of its own act here.
 * @param {any} within the frame's window
 */
export const listenTo = (within) => {
  within.addEventListener("keydown", passOn);
  within.addEventListener("pointerdown", uncoverStage);
};

/**
 * Each page that is loaded into the frame is another one.
 * @param {HTMLIFrameElement} node
 */
const dressPage = (node) => {
  const within = /** @type {any} */ (node.contentWindow);
  const body = node.contentDocument?.body;
  if (!body) return;
  const fit = () => {
    const height = Math.ceil(body.getBoundingClientRect().height);
    // Before there is something in it, it is as high as that usually is.
    if (height && node.style.height !== `${height}px`) node.style.height = `${height}px`;
  };
  // What is in it has its height by its width alone, so this comes to an end.
  new within.ResizeObserver(fit).observe(body);
  fit();
  listenTo(within);
};

/** @param {HTMLIFrameElement} node */
const dress = (node) => {
  let timer = 0;
  const judge = () => {
    const place = node.parentElement?.querySelector(".pounce-no-time");
    clearTimeout(timer);
    if (isOpen(node) && place) place.textContent = "";
    if (isOpen(node)) return;
    timer = setTimeout(() => {
      // Without any connection to the lab that is said, and not this.
      const isConnected = document.documentElement.dataset.connection === "connected";
      if (place && node.isConnected && isConnected) place.textContent = ABSENT;
    }, PATIENCE_MS);
  };
  node.addEventListener("load", () => dressPage(node));
  node.addEventListener("pounce-connection", judge);
  if (node.contentDocument?.readyState === "complete") dressPage(node);
  judge();
};

whenTimeKey(pressInFrame);
whenChanged(() => {
  const node = frame();
  if (!node || met.has(node)) return;
  met.add(node);
  dress(node);
});
