// @ts-check
// One of all headings side by side, as a board by itself.

/** @typedef {import("../player/sent.js").World} World */
/** @typedef {import("./film.js").Board} Board */

const PLANES = ["colours", "dots", "rising", "falling"];
const HEADINGS = 8;

/**
 * A board that shows one heading of those that another one has side by side.
 * @param {Board} board
 * @param {number} heading
 * @param {World} world
 * @returns {Board}
 */
export const alone = (board, heading, world) => {
  /** @type {Board} */
  const found = { ...board, tiles: false, prey: heading, labels: [], hunt: null };
  for (const plane of PLANES) {
    const colours = board[plane];
    if (!colours) continue;
    const size = colours.length / HEADINGS;
    found[plane] = colours.subarray(heading * size, (heading + 1) * size);
  }
  found.lines = board.lines.map((/** @type {import("./film.js").Line} */ line) => ({
    ...line,
    points: line.points.filter((way) => tileOf(way, world) === heading).map((way) => onBoard(way, heading, world)),
  }));
  return found;
};

/**
 * The tile in which a line begins.
 * @param {number[]} way
 * @param {World} world
 */
const tileOf = ([east, north], { size, tiles: { places, share } }) => {
  const half = (size * share) / 2 + 1;
  return places.findIndex(([x, y]) => Math.abs(east - x * size) <= half && Math.abs(north - y * size) <= half);
};

/**
 * A line in a tile, where it lies on a whole board.
 * @param {number[]} way
 * @param {number} heading
 * @param {World} world
 */
const onBoard = (way, heading, { size, tiles: { places, share } }) =>
  way.map((number, place) => (number - places[heading][place % 2] * size) / share);
