// @ts-check
// Which runs are to stand side by side: the live run and branches of the tree, or presets with a seed.

import { attribute, element, write } from "../time/dom.js";
import { on, send } from "../player/pipe.js";
import { ACTS, say } from "./head.js";
import { changed, isRacing, state, whenChanged } from "./state.js";

const FEWEST = 2;
const MOST = 4;
const MOST_SEED = 2 ** 32 - 1;

/** @typedef {{kind: string, seed: number}} Row `kind` is "line 3" or "preset timed" */

const choose = element("section", "choose");
choose.setAttribute("aria-label", "Choose runs");
choose.innerHTML = `
  <div class="ready">
    <h2>The thesis's four</h2>
    <p>Four learners in one world, from the same starts, step for step: nine moves without skills, two skills, three skills, and three that come one after the other. Figure 4.1 as it comes about.</p>
    <button type="button" class="primary" data-do="four">Race the thesis's four</button>
  </div>
  <div class="own">
    <h2>Or choose two to four</h2>
    <ol></ol>
    <p class="acts"><button type="button" data-do="more">One more</button>
      <button type="button" class="primary" data-do="start">Let them run</button>
      <button type="button" data-do="cancel">Cancel</button></p>
    <p class="note">Each run begins at its first trial; one of this session goes as far as it has learned, a preset to its last trial. The live run stands still meanwhile, and is as it was afterwards.</p>
  </div>`;
document.body.append(choose);

const part = (/** @type {string} */ name) => /** @type {HTMLElement} */ (choose.querySelector(name));
const list = part("ol");

/** @type {Row[]} */
let rows = [];
let offered = "";

/** What is offered at first: the run that is live beside its branches, or beside another learner. */
const begin = () => {
  const { choice } = state;
  if (!choice || rows.length) return;
  const lines = choice.lines.slice(0, MOST).map(({ line }) => ({ kind: `line ${line}`, seed: choice.seed }));
  const others = choice.presets.filter((name) => name !== choice.preset);
  rows = lines.length >= FEWEST ? lines : [...lines, { kind: `preset ${others[0]}`, seed: choice.seed }];
};

/** @param {Row} row @param {number} place */
const makeRow = (row, place) => {
  const item = element("li", "");
  const kind = document.createElement("select");
  kind.ariaLabel = `Run ${place + 1}`;
  const { choice } = state;
  for (const [label, options] of /** @type {const} */ ([
    ["Of this session", (choice?.lines ?? []).map(({ line, name }) => [name, `line ${line}`])],
    ["From a preset", (choice?.presets ?? []).map((name) => [name, `preset ${name}`])],
  ])) {
    const group = document.createElement("optgroup");
    group.label = label;
    group.append(...options.map(([text, value]) => new Option(text, value)));
    kind.append(group);
  }
  kind.value = row.kind;
  const seed = document.createElement("input");
  seed.type = "number";
  seed.min = "0";
  seed.max = `${MOST_SEED}`;
  seed.value = `${row.seed}`;
  seed.ariaLabel = `Seed of run ${place + 1}`;
  const label = element("label", "seed", "seed ");
  label.append(seed);
  label.hidden = row.kind.startsWith("line");
  kind.addEventListener("change", () => {
    row.kind = kind.value;
    label.hidden = row.kind.startsWith("line");
  });
  seed.addEventListener("change", () => {
    const number = Math.round(Number(seed.value));
    row.seed = Math.min(Math.max(Number.isFinite(number) ? number : 0, 0), MOST_SEED);
    seed.value = `${row.seed}`;
  });
  item.append(kind, label);
  if (rows.length > FEWEST) {
    const drop = element("button", "drop", "Remove");
    drop.setAttribute("type", "button");
    drop.ariaLabel = `Remove run ${place + 1}`;
    drop.addEventListener("click", () => {
      rows.splice(place, 1);
      offered = "";
      changed();
    });
    item.append(drop);
  }
  return item;
};

/** @type {Record<string, () => unknown>} */
const DOES = {
  four: () => ACTS.four(),
  more: () => {
    const { choice } = state;
    const last = rows.at(-1);
    const next = choice?.presets.find((name) => !rows.some(({ kind }) => kind === `preset ${name}`));
    rows.push({ kind: `preset ${next ?? choice?.preset}`, seed: (last?.seed ?? 0) + (next ? 0 : 1) });
    offered = "";
    changed();
  },
  start: () => {
    const runs = rows.map(({ kind, seed }) => {
      const [what, ...name] = kind.split(" ");
      return what === "line" ? { line: Number(name[0]) } : { preset: name.join(" "), seed };
    });
    if (new Set(runs.map((run) => JSON.stringify(run))).size < runs.length)
      return say("Two of these are the same run: choose another one, or another seed.", true);
    send({ do: "start", runs });
    state.choosing = false;
    changed();
  },
  cancel: () => (isRacing() ? ACTS.choose() : ACTS.close()),
};

choose.addEventListener("click", ({ target }) => {
  const node = /** @type {HTMLElement | null} */ (/** @type {Element} */ (target).closest("[data-do]"));
  if (node) DOES[node.dataset.do ?? ""]?.();
});

whenChanged(() => {
  const isOpen = state.race !== null && (!isRacing() || state.choosing);
  choose.hidden = !isOpen;
  document.body.classList.toggle("choosing", isOpen);
  if (!isOpen) {
    offered = "";
    return;
  }
  begin();
  const key = JSON.stringify([state.choice, rows.length]);
  // What somebody is choosing from is theirs.
  if (key !== offered && !(list.contains(document.activeElement) && offered)) {
    offered = key;
    list.replaceChildren(...rows.map(makeRow));
  }
  /** @type {HTMLButtonElement} */ (part('[data-do="more"]')).disabled = rows.length >= MOST;
  attribute(part('[data-do="more"]'), "title", rows.length >= MOST ? "Four at most" : null);
  write(part('[data-do="cancel"]'), isRacing() ? "Cancel" : "Back to one board");
});

on("said", ({ text, refused }) => say(text, refused));
