// @ts-check
// Where the results of an experiment lie: beside the board in a wide window, in the place of the left
// panel, else over the board; never over the controls, nor over the card of a lesson. The lab draws
// them for the room they have.

import { taken } from "./docks.js";
import { lessonRoom } from "./lesson.js";

const WIDE = matchMedia("(min-width: 1800px)");
/** Narrower than this the curve and the timeline stay in sight. */
const LOW = matchMedia("(max-width: 1365px)");
/** Of a wide window, and of the size that type has in the panels. */
const SHARE = 0.42;
const SMALLER = 0.82;
const GAP_PX = 8;
/** At scale 1 they take so much, even if the left panel is covered. */
const LEAST_PX = 684;
/** In this browser's tab, whether they were open. */
const OPEN = "pounce-results";

const root = document.documentElement;
/** What the lab was told of the room, by the address that it was told at. */
let told = "";
/** The addresses of this connection, once they have been seen. */
let met = "";

const calls = () => /** @type {HTMLElement | null} */ (document.querySelector("[data-results-size]"));
const sheet = () =>
  document.querySelector(".pounce-window")?.closest("[data-floating-window]") ?? null;

/** Room that results take from the left of the stage, in pixels. */
export const resultsRoom = () =>
  sheet() && WIDE.matches && root.dataset.present === undefined ? SHARE * innerWidth : 0;

/** Done again whenever the stage has another place, or the page has changed. */
export const placeResults = () => {
  const isShown = sheet() !== null;
  const { resultsSize = "", resultsOpen = "" } = calls()?.dataset ?? {};
  if (resultsOpen && met !== resultsOpen) {
    met = resultsOpen;
    // What was open before the page was loaded anew.
    if (sessionStorage.getItem(OPEN) && !isShown) return void call(resultsOpen);
  }
  if (met && resultsOpen) {
    if (isShown) sessionStorage.setItem(OPEN, "yes");
    else sessionStorage.removeItem(OPEN);
  }
  if (!isShown) return;
  const scale = Number(getComputedStyle(root).getPropertyValue("--stage-scale")) || 1;
  const beside = resultsRoom();
  const zoom = beside ? Math.max(scale * SMALLER, 1) : scale;
  const end = beside || innerWidth - taken("right") - lessonRoom();
  const start = beside ? 0 : Math.max(Math.min(taken("left"), end - LEAST_PX * scale), 0);
  const footer = document.querySelector("#pounce-stage[data-shape=column] footer");
  const bar = LOW.matches ? footer?.getBoundingClientRect().top : undefined;
  const size = {
    left: start + GAP_PX / 2,
    top: GAP_PX,
    width: end - start - GAP_PX,
    height: Math.max((bar ?? innerHeight) - 2 * GAP_PX, innerHeight / 2),
  };
  for (const [name, value] of Object.entries(size))
    root.style.setProperty(`--results-${name}`, `${value / zoom}px`);
  root.style.setProperty("--results-zoom", `${zoom}`);
  const room = `${Math.round(size.width / zoom)}x${Math.round(size.height / zoom)}`;
  if (resultsSize && told !== resultsSize + room) {
    told = resultsSize + room;
    call(resultsSize + room);
  }
};

/** @param {string} address */
const call = (address) => void fetch(address, { cache: "no-store" });
