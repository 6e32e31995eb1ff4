// @ts-check
// The boards, as large as there is room for: one for each run, and one for what is different.

import { attribute, element, write } from "../time/dom.js";
import { Board } from "../player/board.js";
import { on, send, sendNewest } from "../player/pipe.js";
import { changed, isRacing, state, whenChanged } from "./state.js";
import { swatch } from "./swatch.js";

/**
 * @typedef {{
 *   tile: HTMLElement, board: Board, canvas: HTMLCanvasElement, world: string,
 *   name: HTMLElement, about: Element,
 *   numbers: HTMLElement, stand: Element, digest: Element,
 * }} Tile
 */

/** Least width of a board beside others before they are scrolled, and what the bar needs at least. */
const LEAST_PX = 150;
const BAR_REM = 7.6;
/** What is below the boards of a presentation, without a map of what is different and with one. */
const PRESENTED_REM = [11, 12.2];
const READ_REM = 9.6;
const COMPARED_REM = 13.2;
/** What is read of a run, in a word, and whether it is of the first that matter. */
const NUMBERS = /** @type {const} */ ([
  ["reward", "reward", "Mean reward per trial over the last 500, random moves and all"],
  ["success", "success", "Share of the last 500 trials that ended in capture"],
  ["greedy", "greedy", ""],
  ["trial", "trial", "Hunts that have ended; the runs are level by steps, and not by trials"],
]);

const boards = element("section", "boards");
boards.setAttribute("aria-label", "Boards");
document.body.append(boards);

/** @type {Tile[]} */
let tiles = [];
/** Worlds by their keys. @type {Map<string, any>} */
const worlds = new Map();
/** What the frame was sent of boards last, of each kind. @type {Record<string, any[]>} */
const sent = { boards: [], overs: [] };
let made = "";

/** How often each board was drawn, for whoever measures that. */
/** @type {any} */ (window).pounceSide = () => tiles.map(({ board }) => board.drawn);

/** @returns {Tile} */
const tile = () => {
  const node = element("figure", "tile");
  node.innerHTML = `
    <figcaption>
      <span class="head"><span class="name"></span><span class="leads" hidden>leads</span></span>
      <span class="about"></span>
      <span class="numbers"></span>
    </figcaption>
    <canvas></canvas>
    <span class="foot"><span class="stand"></span><span class="digest"></span></span>`;
  const part = (/** @type {string} */ name) => /** @type {HTMLElement} */ (node.querySelector(name));
  const canvas = /** @type {HTMLCanvasElement} */ (part("canvas"));
  const board = new Board(canvas);
  boards.append(node);
  return {
    ...{ tile: node, board, canvas, world: "", name: part(".name"), about: part(".about") },
    ...{ numbers: part(".numbers"), stand: part(".stand"), digest: part(".digest") },
  };
};

/** Boards are made anew for other runs alone. */
const make = () => {
  const runs = state.race?.runs ?? [];
  const { compare } = state;
  const isCompared = compare?.shown ?? false;
  const key = JSON.stringify([runs, isCompared]);
  if (key === made) return;
  made = key;
  for (const { board } of tiles) board.remove();
  boards.replaceChildren();
  tiles = [...runs, ...(isCompared ? [null] : [])].map((run) => {
    const each = tile();
    if (run) {
      each.name.append(swatch(run.look), run.name);
      write(each.about, run.about);
      each.numbers.append(
        ...NUMBERS.map(([kind, label, hint]) => {
          const number = element("span", kind);
          number.append(element("i", "", label), element("b", ""));
          if (hint) number.title = hint;
          return number;
        }),
      );
    } else {
      each.tile.classList.add("difference");
      each.numbers.remove();
      each.canvas.setAttribute("aria-label", "What is different between two of the runs");
    }
    return each;
  });
  boards.dataset.count = `${tiles.length}`;
  place();
  for (const kind of ["boards", "overs"]) draw(kind);
};

/** Rows and columns in which the boards are as large as can be. */
const place = () => {
  document.body.classList.toggle("racing", isRacing());
  document.body.classList.toggle("compared", state.compare?.shown ?? false);
  if (!tiles.length) return;
  const rem = parseFloat(getComputedStyle(document.documentElement).fontSize);
  const gap = 0.6 * rem;
  const head = document.querySelector("header")?.getBoundingClientRect().height ?? 0;
  const width = document.documentElement.clientWidth - 2 * gap;
  // Of a presentation it is the boards that are looked at, and of what is read but the colours.
  const isPresented = document.documentElement.hasAttribute("data-present");
  const isCompared = state.compare?.shown ?? false;
  const read = isCompared ? COMPARED_REM : READ_REM;
  const below = isPresented ? PRESENTED_REM[Number(isCompared)] : BAR_REM + read;
  // Eight headings lie in two rows of four.
  const ratio = boards.classList.contains("tiled") ? 0.5 : 1;
  const height = innerHeight - head - below * rem - gap;
  const [{ tile: first, canvas }] = tiles;
  const around = first.getBoundingClientRect().height - canvas.getBoundingClientRect().height + gap;
  let best = { columns: 1, size: 0 };
  for (let columns = 1; columns <= tiles.length; columns += 1) {
    const rows = Math.ceil(tiles.length / columns);
    const size = Math.min((width - (columns - 1) * gap) / columns, (height / rows - around) / ratio);
    if (size > best.size) best = { columns, size };
  }
  const isCramped = best.size < LEAST_PX;
  // One scrolls then, and two beside each other can still be compared at a glance.
  if (isCramped) best = { columns: 2, size: Math.min((width - gap) / 2, innerHeight * 0.6) };
  document.body.classList.toggle("cramped", isCramped);
  boards.style.setProperty("--columns", `${best.columns}`);
  boards.style.setProperty("--board", `${Math.floor(best.size)}px`);
};

/** @param {string} kind */
const draw = (kind) => {
  tiles.forEach((each, index) => {
    const part = sent[kind][index];
    if (!part) return;
    if (part.world && part.world !== each.world && worlds.has(part.world)) {
      each.world = part.world;
      each.board.world(worlds.get(part.world));
    }
    each.board.show(part);
  });
};

on("worlds", (message) => {
  for (const world of message.worlds) worlds.set(world.key, world);
  draw("boards");
});
for (const kind of ["boards", "overs"])
  on(kind, (message) => {
    sent[kind] = message.boards;
    const isTiled = sent.boards[0]?.tiles ?? false;
    if (boards.classList.contains("tiled") !== isTiled) {
      boards.classList.toggle("tiled", isTiled);
      place();
    }
    draw(kind);
  });

let marked = "";
/** Show which cell is read, on all boards. @param {{east: number, north: number} | null} cell */
const markCell = (cell) => {
  const key = JSON.stringify([cell, tiles.length]);
  if (key === marked) return;
  marked = key;
  for (const { board } of tiles) board.mark(cell);
};

const read = () => {
  make();
  const { readings, legend, compare, race, cell } = state;
  markCell(cell?.rows ? { east: cell.east, north: cell.north } : null);
  tiles.forEach((each, index) => {
    const run = readings?.runs[index];
    if (!run || each.tile.classList.contains("difference")) return;
    for (const [kind] of NUMBERS) {
      const value = each.numbers.querySelector(`.${kind} b`);
      if (value) write(value, run[kind]);
    }
    attribute(
      /** @type {Element} */ (each.numbers.querySelector(".greedy")),
      "title",
      `Mean reward of hunts without random moves, in which nothing is learned; ${run.measured}`,
    );
    each.tile.classList.toggle("leading", run.leads);
    /** @type {HTMLElement} */ (each.tile.querySelector(".leads")).hidden = !run.leads;
    write(each.stand, run.stand);
    write(each.digest, run.digest ? `digest ${run.digest.slice(0, 8)}` : "");
    attribute(each.digest, "title", run.digest ? `Of its tables: ${run.digest}` : null);
    each.board.describe(`${race?.runs[index]?.name}: ${legend?.captions[index] ?? ""}`);
    attribute(each.canvas, "title", legend?.captions[index] ?? null);
  });
  const last = tiles.at(-1);
  if (compare?.shown && last?.tile.classList.contains("difference") && race) {
    write(last.name, "Difference");
    write(last.about, compare.caption);
  }
};
whenChanged(read);

// --- The cell under the pointer, in all runs ---------------------------------------------------------

/** @param {PointerEvent} event */
const point = (event) => {
  const canvas = /** @type {Element} */ (event.target).closest("canvas");
  const hit = tiles.find((each) => each.canvas === canvas)?.board.cellAt(event.clientX, event.clientY);
  if (!hit) return;
  const { east, north, heading } = hit;
  const at = { do: "point", east: Math.round(east), north: Math.round(north) };
  sendNewest(heading === null || heading === undefined ? at : { ...at, heading });
};
let isKept = false;
boards.addEventListener("pointermove", (event) => {
  if (!isKept && event.pointerType === "mouse") point(event);
});
boards.addEventListener("click", (event) => {
  // What was clicked stays until another click.
  if (!(/** @type {Element} */ (event.target).closest("canvas"))) return;
  isKept = !isKept || event.detail > 1;
  boards.classList.toggle("kept", isKept);
  point(/** @type {PointerEvent} */ (event));
});
boards.addEventListener("pointerleave", ({ pointerType }) => {
  if (!isKept && pointerType === "mouse") send({ do: "unpoint" });
});

// Of a presentation the height that what is said takes changes, too.
const watch = new ResizeObserver(() => {
  place();
  changed();
});
watch.observe(document.querySelector("header") ?? document.body);
watch.observe(document.documentElement);
