// @ts-check
// Where a board lies on a canvas, whole or as one of eight tiles.

/** @typedef {import("./sent.js").World} World */

/**
 * A canvas that is drawn on: how many pixels it has, how many of them are one of a style's, and the
 * family of its type.
 * @typedef {{width: number, height: number, ratio: number, font: string}} Sheet
 */

/** What stays free round a board for its border, as a share of its side. */
const MARGIN = 0.006;

export class Place {
  /**
   * @param {World} world
   * @param {number} left edge, in pixels of the canvas
   * @param {number} top
   * @param {number} side
   * @param {Sheet} sheet
   * @param {boolean} round
   * @param {number | null} heading the one it shows by itself
   */
  constructor(world, left, top, side, sheet, round, heading) {
    this.world = world;
    this.left = left;
    this.top = top;
    this.side = side;
    this.sheet = sheet;
    this.ratio = sheet.ratio;
    this.font = sheet.font;
    this.round = round;
    this.heading = heading;
    /** Side of a cell in pixels. */
    this.cell = side / world.size;
    /** The west and the south edge, and the others, in cells from the prey. */
    this.low = -0.5 - Math.floor(world.size / 2);
    this.high = this.low + world.size;
    /** The middle of the prey's cell. */
    this.x = left - this.low * this.cell;
    this.y = top + this.high * this.cell;
  }

  /**
   * Where a place lies that is so many cells from the prey.
   * @param {number} east
   * @param {number} north
   * @returns {[number, number]}
   */
  to(east, north) {
    return [this.x + east * this.cell, this.y - north * this.cell];
  }

  /**
   * What lies at a pixel, in cells from the prey.
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

/**
 * The whole board in the middle of a sheet, as large as there is room.
 * @param {World} world
 * @param {Sheet} sheet
 * @param {boolean} round
 * @param {number} [high] its height as a share of its width
 */
export const boardPlace = (world, sheet, round, high = 1) => {
  const { width, height } = sheet;
  const side = Math.max(Math.floor(Math.min(width, height / high) * (1 - 2 * MARGIN)), 1);
  const [left, top] = [Math.round((width - side) / 2), Math.round((height - side) / 2)];
  return new Place(world, left, top, side, sheet, round, null);
};

/**
 * What all headings side by side take, as if that were a board.
 * @param {World} world
 * @param {Sheet} sheet
 */
export const tilesPlace = (world, sheet) => boardPlace(world, sheet, false, world.tiles.height);

/**
 * Each of them.
 * @param {Place} whole
 */
export const tilePlaces = (whole) => {
  const { world, sheet } = whole;
  const side = Math.round(whole.side * world.tiles.share);
  const [x, y] = [whole.left + whole.side / 2, whole.top + whole.side / 2];
  return world.tiles.places.map(([east, north], heading) => {
    const left = Math.round(x + east * whole.side - side / 2);
    const top = Math.round(y - north * whole.side - side / 2);
    return new Place(world, left, top, side, sheet, false, heading);
  });
};
