// @ts-check
// What is read below the bar: colours of the boards, where two runs went different ways, and what all
// runs know of the cell under the pointer.

import { attribute, element, write } from "../time/dom.js";
import { on, send } from "../player/pipe.js";
import { put } from "../player/html.js";
import { changed, isRacing, state, whenChanged } from "./state.js";
import { swatch } from "./swatch.js";

const read = element("section", "read");
read.innerHTML = `
  <div class="colours"><h2></h2><div class="pounce"></div><div class="pounce map-legend"></div></div>
  <div class="apart">
    <h2>Compare <select class="one" aria-label="One of two runs"></select> with
      <select class="other" aria-label="The other run"></select></h2>
    <p class="text"></p>
    <button type="button" class="go">Go there</button>
    <div><label><input type="checkbox" class="map" /> Map of what is different</label></div>
  </div>
  <div class="cell"><h2></h2><table></table></div>`;
document.body.append(read);

const part = (/** @type {string} */ name) => /** @type {HTMLElement} */ (read.querySelector(name));
const one = /** @type {HTMLSelectElement} */ (part(".one"));
const other = /** @type {HTMLSelectElement} */ (part(".other"));
const map = /** @type {HTMLInputElement} */ (part(".map"));
const go = /** @type {HTMLButtonElement} */ (part(".go"));

/** So long what a hand has chosen stands, unless the lab has said the same before. */
const PATIENCE_MS = 3_000;
/** @typedef {{one: number, other: number, shown: boolean}} Pair */
/** What a hand has chosen of which runs, and when: until the lab says the same, what it says was said before. @type {{pair: Pair, names: string, at: number} | null} */
let wished = null;

const names = () => state.race?.runs.map(({ name }) => name).join("\n") ?? "";

on("compare", (told) => {
  const isSame = wished && told.one === wished.pair.one && told.other === wished.pair.other && told.shown === wished.pair.shown;
  const isOver = !wished || isSame || wished.names !== names() || performance.now() - wished.at > PATIENCE_MS;
  if (isOver) wished = null;
  state.compare = { ...told, ...wished?.pair };
  changed();
});

const showColours = () => {
  const { legend } = state;
  write(part(".colours h2"), legend?.layer ?? "");
  put(part(".colours .pounce"), legend?.html ?? "");
};

const showApart = () => {
  const { compare, race } = state;
  part(".apart").hidden = !compare || !race;
  if (!compare || !race) return;
  const options = names();
  for (const [list, chosen] of /** @type {const} */ ([
    [one, compare.one],
    [other, compare.other],
  ])) {
    if (list.dataset.options !== options) {
      list.dataset.options = options;
      list.replaceChildren(...race.runs.map(({ name }, place) => new Option(name, `${place}`)));
    }
    if (document.activeElement !== list) list.value = `${chosen}`;
  }
  map.checked = compare.shown;
  write(part(".apart .text"), compare.text);
  go.hidden = compare.step === null;
  put(part(".map-legend"), compare.shown ? compare.legend : "");
};

const compare = () => {
  const pair = { one: Number(one.value), other: Number(other.value) };
  if (pair.one === pair.other) pair.other = (pair.one + 1) % (state.race?.runs.length ?? 2);
  const wanted = { ...pair, shown: map.checked };
  // What is drawn before the lab answers does not take it back.
  if (state.compare) state.compare = { ...state.compare, ...wanted };
  if (send({ do: "compare", ...wanted })) wished = { pair: wanted, names: names(), at: performance.now() };
};
for (const field of [one, other, map])
  field.addEventListener("change", () => {
    compare();
    field.blur();
  });
go.addEventListener("click", () => {
  if (state.compare?.step !== null) send({ do: "seek", step: state.compare?.step });
});

let shownCell = "";

/** Where a cell is, in words. @param {{east: number, north: number}} cell */
const placed = ({ east, north }) => {
  const parts = [
    [Math.abs(east), east > 0 ? "east" : "west"],
    [Math.abs(north), north > 0 ? "north" : "south"],
  ].filter(([far]) => far);
  return parts.length ? `${parts.map((part) => part.join(" ")).join(", ")} of the prey` : "of the prey";
};

const showCell = () => {
  const { cell, race } = state;
  const rows = cell?.rows;
  const place = cell ? placed(cell) : "";
  write(
    part(".cell h2"),
    rows ? `The cell ${place}` : "Point at a board: what each run knows of that cell",
  );
  const key = JSON.stringify([rows, race?.runs]);
  if (key === shownCell) return;
  shownCell = key;
  const table = part(".cell table");
  table.replaceChildren();
  if (!rows || !race) return;
  const top = element("tr", "");
  top.append(
    element("td", ""),
    ...race.runs.map(({ name, look }) => {
      const column = element("th", "");
      column.setAttribute("scope", "col");
      column.append(swatch(look), name);
      return column;
    }),
  );
  table.append(
    top,
    ...rows.map(({ what, values, hint }) => {
      const row = element("tr", "");
      const label = element("th", "", what);
      label.setAttribute("scope", "row");
      attribute(label, "title", hint || null);
      row.append(label, ...values.map((value) => element("td", "", value)));
      return row;
    }),
  );
};

whenChanged(() => {
  read.hidden = !isRacing();
  showColours();
  showApart();
  showCell();
});
