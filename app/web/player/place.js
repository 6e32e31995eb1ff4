// @ts-check
// Where a board lies on a canvas, whole or as one of eight tiles.

/** @typedef {import("./sent.js").World} World */

export class Place {
  /**
   * @param {World} world
   * @param {number} x of the middle of the prey's cell, in pixels of the canvas
   * @param {number} y
   * @param {number} cell side of a cell
   * @param {boolean} round
   * @param {number | null} heading the one it shows by itself
   */
  constructor(world, x, y, cell, round, heading) {
    this.world = world;
    this.x = x;
    this.y = y;
    this.cell = cell;
    this.round = round;
    this.heading = heading;
    /** The west and the south edge, in cells from the prey. */
    this.low = -0.5 - Math.floor(world.size / 2);
    this.high = this.low + world.size;
  }

  /** Pixels along each side. */
  get side() {
    return this.world.size * this.cell;
  }

  get left() {
    return this.x + this.low * this.cell;
  }

  get top() {
    return this.y - this.high * this.cell;
  }

  /**
   * Where cells lie.
   * @param {number} east
   * @param {number} north
   * @returns {[number, number]}
   */
  to(east, north) {
    return [this.x + east * this.cell, this.y - north * this.cell];
  }

  /**
   * What lies at a pixel.
   * @param {number} x
   * @param {number} y
   * @returns {[number, number]}
   */
  at(x, y) {
    return [(x - this.x) / this.cell, (this.y - y) / this.cell];
  }

  /**
   * Whether a place is on the board.
   * @param {number} east
   * @param {number} north
   */
  has(east, north) {
    if (this.round) return Math.hypot(east, north) <= this.world.rim;
    return Math.min(east, north) >= this.low && Math.max(east, north) < this.high;
  }
}

/** What stays free round a board for its border, as a share of its side. */
const MARGIN = 0.008;
/** Pixels from which on a cell is large. */
const LARGE = 5;

/**
 * The whole board, as large as there is room.
 * @param {World} world
 * @param {number} width of the canvas
 * @param {number} height
 * @param {boolean} round
 */
export const boardPlace = (world, width, height, round) => {
  const side = Math.min(width, height) * (1 - 2 * MARGIN);
  // A whole number of pixels for each cell keeps patterns even, and costs little where cells are large.
  const cell = side / world.size >= LARGE ? Math.floor(side / world.size) : Math.floor(side) / world.size;
  const middle = Math.floor(world.size / 2) + 0.5;
  const [left, top] = [(width - cell * world.size) / 2, (height - cell * world.size) / 2];
  const [x, y] = [Math.round(left) + middle * cell, Math.round(top) + (world.size - middle) * cell];
  return new Place(world, x, y, cell, round, null);
};

/**
 * All headings side by side.
 * @param {World} world
 * @param {number} width
 * @param {number} height
 */
export const tilePlaces = (world, width, height) => {
  const whole = boardPlace(world, width, height, false);
  const { share, places } = world.tiles;
  return places.map(([east, north], heading) => {
    const [x, y] = whole.to(east * world.size, north * world.size);
    return new Place(world, x, y, whole.cell * share, false, heading);
  });
};
