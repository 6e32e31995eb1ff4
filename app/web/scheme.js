// @ts-check
// Dark or light: as the browser asks for, until somebody chooses, which this browser remembers.

import { whenChanged } from "./changes.js";

/** What `first.js` reads before there is anything to see. */
const CHOICE = "pounce-scheme";
const root = document.documentElement;

/** Whose element it was: one of each connection. */
let met = "";
/** What was asked for and is not so yet. */
let asked = "";

const follow = () => {
  const told = document.querySelector("[data-scheme]");
  if (!(told instanceof HTMLElement)) return;
  const { scheme = "", darkCall = "", lightCall = "" } = told.dataset;
  if (met !== darkCall) {
    met = darkCall;
    asked = root.dataset.wanted ?? "light";
    if (asked !== scheme)
      void fetch(asked === "dark" ? darkCall : lightCall, { cache: "no-store" });
  }
  if (asked === scheme) asked = "";
  if (asked) return;
  root.dataset.settled = "";
  // From here on, what it is has been chosen.
  if (root.dataset.wanted !== scheme) localStorage.setItem(CHOICE, scheme);
  root.dataset.wanted = scheme;
};

new MutationObserver(follow).observe(document.body, {
  attributeFilter: ["data-scheme"],
  subtree: true,
});
whenChanged(follow);
