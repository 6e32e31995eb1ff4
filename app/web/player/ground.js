// @ts-check
// The colours of a board: states are spread over cells, and cells are drawn as they are, however
// large.
import { bytesOf } from "./sent.js";

/** @typedef {import("./sent.js").World} World */
/** @typedef {import("./sent.js").Sent} Sent */
/** @typedef {import("./place.js").Place} Place */

/** In the order in which one lies over another, where they differ. */
const PATTERNS = /** @type {const} */ (["falling", "rising", "dots"]);
const OPAQUE = 255 << 24;

/**
 * RGB of as many colours as there are, in base64 or as bytes, as pixels of an image.
 * @param {string | Uint8Array} text
 */
const pixelsOf = (text) => {
  const bytes = bytesOf(text);
  const pixels = new Uint32Array(bytes.length / 3);
  for (let i = 0, at = 0; i < pixels.length; i++, at += 3) {
    pixels[i] = OPAQUE | (bytes[at + 2] << 16) | (bytes[at + 1] << 8) | bytes[at];
  }
  return pixels;
};

/** A raster over a board: what decides the colour of each pixel, from the north-west on. */
class Raster {
  /**
   * @param {World} world
   * @param {Uint16Array} states of cells
   * @param {number} side
   */
  constructor(world, states, side) {
    const { size } = world;
    this.side = side;
    /** Patterns that lie over a pixel, as bits, and its state after them. */
    this.index = new Uint32Array(side * side);
    /** The cell under each. */
    this.cells = new Uint32Array(side * side);
    /** Those of a round board. */
    this.isRound = new Uint8Array(side * side);
    const middle = Math.floor(size / 2);
    for (let row = 0, at = 0; row < side; row++) {
      const y = Math.floor(((2 * (side - 1 - row) + 1) * size) / (2 * side));
      for (let column = 0; column < side; column++, at++) {
        const x = Math.floor(((2 * column + 1) * size) / (2 * side));
        // As app/picture/raster.py has them.
        const falling = (x + y) % 4 === 0;
        const rising = (x - y) % 4 === 0;
        const dots = x % 3 === 1 && y % 3 === 1;
        const bits = Number(falling) | (Number(rising) << 1) | (Number(dots) << 2);
        this.cells[at] = y * size + x;
        this.index[at] = bits * world.n_states + states[y * size + x];
        this.isRound[at] = Number(Math.hypot(x - middle, y - middle) <= world.rim);
      }
    }
    this.canvas = document.createElement("canvas");
    this.canvas.width = side;
    this.canvas.height = side;
    this.context = /** @type {CanvasRenderingContext2D} */ (this.canvas.getContext("2d"));
    this.image = this.context.createImageData(side, side);
    this.pixels = new Uint32Array(this.image.data.buffer);
    this.large = document.createElement("canvas");
  }

  /**
   * The raster with each pixel a whole number of times as large, and all at least of a side: made
   * smaller from there, pixels are alike, and so are patterns of them.
   * @param {number} side
   */
  enlarged(side) {
    const times = Math.ceil(side / this.side);
    const { canvas, large } = this;
    if (times <= 1) return canvas;
    if (large.width !== times * this.side) large.width = large.height = times * this.side;
    const context = /** @type {CanvasRenderingContext2D} */ (large.getContext("2d"));
    context.imageSmoothingEnabled = false;
    context.clearRect(0, 0, large.width, large.height);
    context.drawImage(canvas, 0, 0, large.width, large.height);
    return large;
  }
}

export class Ground {
  /** @type {World | undefined} */
  #world;
  /** @type {Uint16Array} */
  #states = new Uint16Array();
  /** @type {Map<number, Raster>} */
  #rasters = new Map();
  /** Of each board, its colours by pattern bits and state; or by cell. @type {Uint32Array[]} */
  #tables = [];

  /** @param {World} world */
  world(world) {
    if (world.key === this.#world?.key) return;
    this.#world = world;
    // Platforms are little-endian, as what is sent.
    this.#states = new Uint16Array(bytesOf(world.states).buffer);
    this.#rasters.clear();
    this.#tables = [];
  }

  /**
   * Take colours in; they are spread over the board when that is drawn.
   * @param {Sent} sent
   */
  colour(sent) {
    const plain = pixelsOf(/** @type {string | Uint8Array} */ (sent.colours));
    const boards = sent.tiles ? 8 : 1;
    const each = plain.length / boards;
    this.#tables = Array.from({ length: boards }, (_, board) => plain.subarray(board * each, (board + 1) * each));
    if (sent.by === "cell") return;
    const patterns = PATTERNS.map((name) => (sent[name] ? pixelsOf(/** @type {string | Uint8Array} */ (sent[name])) : null));
    this.#tables = this.#tables.map((colours, board) => {
      const table = new Uint32Array(8 * each);
      for (let bits = 0; bits < 8; bits++) {
        table.set(colours, bits * each);
        patterns.forEach((pattern, number) => {
          if (!pattern || !(bits & (1 << number))) return;
          for (let state = 0; state < each; state++) {
            const colour = pattern[board * each + state];
            if (colour !== colours[state]) table[bits * each + state] = colour;
          }
        });
      }
      return table;
    });
  }

  /**
   * @param {CanvasRenderingContext2D} context
   * @param {Place[]} places
   * @param {Sent} sent
   */
  draw(context, places, sent) {
    const world = this.#world;
    if (!world || this.#tables.length !== places.length) return;
    const raster = this.#raster(world, sent.tiles ? world.tiles.side : world.size);
    places.forEach((place, board) => {
      this.#fill(raster, this.#tables[board], sent, place.round);
      const { left, top, side } = place;
      const drawn = raster.enlarged(side);
      context.imageSmoothingEnabled = drawn.width !== side;
      context.drawImage(drawn, left, top, side, side);
    });
  }

  /**
   * @param {World} world
   * @param {number} side
   */
  #raster(world, side) {
    const raster = this.#rasters.get(side) ?? new Raster(world, this.#states, side);
    this.#rasters.set(side, raster);
    return raster;
  }

  /**
   * @param {Raster} raster
   * @param {Uint32Array} table
   * @param {Sent} sent
   * @param {boolean} round
   */
  #fill(raster, table, sent, round) {
    const { pixels, isRound } = raster;
    // Colours by cell come from the south-west on, in tiles for each pixel.
    const isTile = sent.tiles;
    const { side } = raster;
    if (sent.by !== "cell") {
      const { index } = raster;
      for (let i = 0; i < pixels.length; i++) pixels[i] = table[index[i]];
    } else {
      for (let i = 0; i < pixels.length; i++) {
        pixels[i] = table[isTile ? (side - 1 - Math.floor(i / side)) * side + (i % side) : raster.cells[i]];
      }
    }
    if (round) for (let i = 0; i < pixels.length; i++) if (!isRound[i]) pixels[i] = 0;
    raster.context.putImageData(raster.image, 0, 0);
  }
}
