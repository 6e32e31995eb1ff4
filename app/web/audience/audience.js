// @ts-check
// The page of an audience: what the presenter shows, on whatever one has at hand.

import "../terms.js";
import { put } from "../player/html.js";
import { on } from "../player/pipe.js";
import "../time/tip.js";
import { begin as beginAround } from "./around.js";
import "./ask.js";
import { board } from "./board.js";
import { begin as connect } from "./line.js";
import "./own.js";

/** What is said aloud is said no more often. */
const SAID_MS = 10_000;

/** @param {string} id */
const part = (id) => /** @type {HTMLElement} */ (document.getElementById(id));

const main = /** @type {HTMLElement} */ (document.querySelector("main"));
const modes = /** @type {HTMLElement} */ (document.querySelector(".modes"));
let lab = "";

/** @param {HTMLElement} place @param {string} text */
const write = (place, text) => {
  if (place.textContent !== text) place.textContent = text;
  place.hidden = !text;
};

/** @param {string} text */
const tell = (text) => write(part("connection"), text);

on("lab", ({ lab: told }) => {
  // Another lab is at the same address now: nothing of the former one holds, be it a script.
  if (lab && lab !== told) location.reload();
  lab = told;
});

on("stand", ({ begun, away, follows, own }) => {
  main.hidden = !begun;
  modes.hidden = !begun;
  part("mine").hidden = !own;
  write(part("waiting"), begun ? "" : "The presenter has not begun. What they show will be here.");
  write(part("note"), away && follows ? "The presenter's page is closed. This is how they left it." : "");
});

on("world", ({ world }) => board.world(world));
on("ground", ({ board: sent }) => board.show(sent));
on("over", ({ board: sent }) => board.show(sent));
on("legend", ({ html, title }) => {
  write(part("title"), title);
  put(part("legend"), html);
});
on("readings", ({ html }) => put(part("readings"), html));
let saidAt = -SAID_MS;
let timer = 0;
on("said", ({ html, caption, described }) => {
  put(part("sentence"), html);
  write(part("caption"), caption);
  board.describe(described);
  clearTimeout(timer);
  const aloud = () => {
    saidAt = performance.now();
    part("told").textContent = part("sentence").hidden ? "" : part("sentence").textContent;
  };
  timer = setTimeout(aloud, Math.max(saidAt + SAID_MS - performance.now(), 0));
});

beginAround();
connect(tell);
