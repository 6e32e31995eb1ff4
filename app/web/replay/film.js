// @ts-check
// A film, as `app/player/film.py` writes it: boards of many moments, exact to the last colour.

import { bytesOf } from "../player/sent.js";

/** What of a board is a colour for each state; where one is not there it is as the first. */
const PLANES = ["colours", "dots", "rising", "falling"];
/** Bytes of a colour for light pages and of that for dark ones. */
const PAIR = 6;

/**
 * @typedef {{line: number, step: number, trial: number, said: string[]}} Shot `said` is what is read
 *   of it whatever is seen
 * @typedef {import("../player/sent.js").Line} Line
 * @typedef {Record<string, any>} Board as `app/player/boards.py` sends it, but that colours of states are bytes
 */

/** @param {number[]} numbers */
const ends = (numbers) => {
  const found = new Uint32Array(numbers.length + 1);
  numbers.forEach((number, place) => (found[place + 1] = found[place] + number));
  return found;
};

/** Takes what is in a film apart, from its beginning to its end. */
class Reader {
  /** @param {Uint8Array} raw @param {number} place */
  constructor(raw, place) {
    this.raw = raw;
    this.place = place;
  }

  /** @param {number} size */
  #next(size) {
    this.place += size;
    return this.raw.subarray(this.place - size, this.place);
  }

  /**
   * What each state has at each moment: its place in a palette.
   * @param {number} moments @param {number} states @param {number} bytes of a place
   */
  planes(moments, states, bytes) {
    const size = moments * states;
    const low = this.#next(size);
    const high = bytes === 2 ? this.#next(size) : null;
    const places = bytes === 2 ? new Uint16Array(size) : new Uint8Array(size);
    for (let at = 0; at < size; at++) {
      const less = low[at] | (high ? high[at] << 8 : 0);
      places[at] = (at < states ? 0 : places[at - states]) + less;
    }
    return places;
  }

  /**
   * Points of lines, of so many each.
   * @param {number[]} lengths @param {number} parts of a cell
   */
  ways(lengths, parts) {
    const size = lengths.reduce((sum, length) => sum + length, 0);
    const [east, north] = [0, 1].map(() => [this.#next(size), this.#next(size)]);
    const less = (/** @type {Uint8Array[]} */ [low, high], /** @type {number} */ at) =>
      ((low[at] | (high[at] << 8)) << 16) >> 16;
    let at = 0;
    return lengths.map((length) => {
      const points = new Array(2 * length);
      let [x, y] = [0, 0];
      for (let place = 0; place < length; place++, at++) {
        x += less(east, at);
        y += less(north, at);
        points[2 * place] = x / parts;
        points[2 * place + 1] = y / parts;
      }
      return points;
    });
  }
}

/** One way to see all moments. */
class View {
  /**
   * @param {any} head @param {string[]} texts @param {number} moments @param {Reader} reader
   * @param {number} parts
   */
  constructor(head, texts, moments, reader, parts) {
    this.head = head;
    this.texts = texts;
    /** @type {Array<{name: string, states: number, palette: Uint8Array, places: Uint8Array | Uint16Array}>} */
    this.planes = [];
    for (const name of PLANES) {
      const plane = head.planes[name];
      if (!plane) continue;
      const palette = bytesOf(plane.colours);
      const bytes = palette.length / PAIR > 256 ? 2 : 1;
      const { states } = plane;
      this.planes.push({ name, states, palette, places: reader.planes(moments, states, bytes) });
    }
    this.ways = reader.ways(head.lengths, parts);
    this.lines = ends(head.lines);
    this.ofLine = ends(head.ways);
  }

  /**
   * @param {number} moment @param {boolean} isDark
   * @returns {Board}
   */
  board(moment, isDark) {
    const side = isDark ? 1 : 0;
    const board = JSON.parse(this.texts[this.head.rests[moment][side]]);
    for (const { name, states, palette, places } of this.planes) {
      const colours = new Uint8Array(3 * states);
      for (let state = 0; state < states; state++) {
        const from = PAIR * places[moment * states + state] + 3 * side;
        for (let part = 0; part < 3; part++) colours[3 * state + part] = palette[from + part];
      }
      board[name] = colours;
    }
    board.lines = [];
    for (let line = this.lines[moment]; line < this.lines[moment + 1]; line++) {
      const look = JSON.parse(this.texts[this.head.looks[line]]);
      const points = this.ways.slice(this.ofLine[line], this.ofLine[line + 1]);
      board.lines.push({ ...look[side], points });
    }
    return board;
  }

  /** What is read beside the board. @param {number} moment @returns {string[]} */
  said(moment) {
    return this.head.rests[moment].slice(2).map((/** @type {number} */ place) => this.texts[place]);
  }
}

/** All that was filmed. */
class Film {
  /** @param {Uint8Array} raw */
  constructor(raw) {
    const length = new DataView(raw.buffer, raw.byteOffset).getUint32(0, true);
    const head = JSON.parse(new TextDecoder().decode(raw.subarray(4, 4 + length)));
    const reader = new Reader(raw, 4 + length);
    const { texts, shots, said, points } = head;
    /** @type {Shot[]} */
    this.shots = shots.map((/** @type {number[]} */ [line, step, trial], /** @type {number} */ place) => {
      const words = said[place].map((/** @type {number} */ text) => texts[text]);
      return { line, step, trial, said: words };
    });
    this.texts = texts;
    /** @type {Map<string, View>} */
    this.views = new Map();
    for (const [name, view] of Object.entries(head.views))
      this.views.set(name, new View(view, texts, shots.length, reader, points));
    this.trails = reader.ways(head.trails, points);
  }

  /**
   * The board of a moment.
   * @param {string} name of a view
   * @param {number} moment
   * @param {boolean} isDark
   * @returns {Board}
   */
  board(name, moment, isDark) {
    const view = /** @type {View} */ (this.views.get(name));
    const board = view.board(moment, isDark);
    const [light, dark, trail] = view.head.hunts[moment];
    const hunt = JSON.parse(this.texts[isDark ? dark : light]);
    board.hunt = hunt && { ...hunt, trail: this.trails[trail] };
    return board;
  }

  /**
   * What is read beside it: the legend on light pages, that on dark ones, the caption, and what the
   * board is for those who do not see it.
   * @param {string} name
   * @param {number} moment
   */
  said(name, moment) {
    return /** @type {View} */ (this.views.get(name)).said(moment);
  }
}

/**
 * Open a film.
 * @param {string} packed in base64, deflated
 */
export const openFilm = async (packed) => {
  const stream = new Blob([bytesOf(packed)]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Film(new Uint8Array(await new Response(stream).arrayBuffer()));
};
