// @ts-check
// What lies over the colours of a board: its border, lines, the prey, and words.

/** @typedef {import("./sent.js").Sent} Sent */
/** @typedef {import("./sent.js").Line} Line */
/** @typedef {import("./sent.js").Theme} Theme */
/** @typedef {import("./sent.js").Word} Word */
/** @typedef {import("./place.js").Place} Place */

/** Pixels along each side of the board for which the widths of lines are meant. */
const WIDTHS_FOR = 640;
/** They become so much narrower and wider at most, and no line thinner than so many pixels. */
const [NARROWEST, WIDEST, THINNEST] = [0.5, 1.6, 0.9];
/** The board of the lab is so many units wide, in which sizes of things on it are given. */
const UNITS = 12;
const FIELD = 3;
const ARROW = 4;
const BORDER = 2;
/** Along an arrow that shows where the prey looks: where it begins and ends, and its wings. */
const [TAIL, TIP, WING] = [0.12, 0.62, 0.2];
const PREY = 0.13;
/** Of an arrow among many, the wings as a share of it. */
const BARB = 0.38;
/** The mark of a cell is at least so large. */
const MARK = 0.11;
/** Of lines of words. */
const LABEL = 0.34;
const TILE_LABEL = 0.29;
/** Letters as a share of their line, and at least so many pixels of the page large. */
const [LETTERS, SMALLEST] = [0.95, 9.5];
/** The patch under a word, in letters: what it has beside it, its height, its corners; how it covers. */
const [PAD, TALL, ROUNDED, PATCH] = [0.4, 1.15, 0.2, 0.88];

/**
 * A board unit in pixels.
 * @param {Place} place
 */
export const unitOf = (place) => place.side / UNITS;

/**
 * The width of a line in pixels of the canvas.
 * @param {Place} place
 * @param {number} width
 */
export const widthOn = ({ side, ratio }, width) => {
  const share = Math.min(Math.max(side / ratio / WIDTHS_FOR, NARROWEST), WIDEST);
  return Math.max(width * share, THINNEST) * ratio;
};

/**
 * Put a line through points into the path.
 * @param {CanvasRenderingContext2D} context
 * @param {Place} place
 * @param {number[]} points x, y, x, y ...
 */
export const trace = (context, place, points) => {
  for (let i = 0; i < points.length; i += 2) {
    const [x, y] = place.to(points[i], points[i + 1]);
    if (i) context.lineTo(x, y);
    else context.moveTo(x, y);
  }
};

/**
 * The wings of an arrow, as a line from one over the tip to the other.
 * @param {number[]} arrow x and y of its tail and of its head
 */
const wingsOf = ([fromX, fromY, toX, toY]) => {
  const [x, y] = [BARB * (fromX - toX), BARB * (fromY - toY)];
  // To both sides of the shaft, by a triangle of sides 3, 4 and 5.
  return [toX + 0.8 * x - 0.6 * y, toY + 0.6 * x + 0.8 * y, toX, toY, toX + 0.8 * x + 0.6 * y, toY - 0.6 * x + 0.8 * y];
};

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Place} whole
 * @param {Line[]} lines
 */
export const drawLines = (context, whole, lines) => {
  context.lineCap = context.lineJoin = "round";
  for (const { colour, width, points, arrows } of lines) {
    context.beginPath();
    context.strokeStyle = colour;
    context.lineWidth = widthOn(whole, width);
    for (const piece of points) {
      trace(context, whole, piece);
      if (arrows) trace(context, whole, wingsOf(piece));
    }
    context.stroke();
  }
};

/**
 * The heading of the prey in a picture; null where it does not matter.
 * @param {Place} place
 * @param {Sent} sent
 */
const headingOf = (place, sent) => (sent.prey === null ? null : (place.heading ?? sent.prey ?? null));

/**
 * The border of a board, and what the prey sees.
 * @param {CanvasRenderingContext2D} context
 * @param {Place} place
 * @param {Sent} sent
 */
export const drawBorder = (context, place, sent) => {
  const theme = /** @type {Theme} */ (sent.theme);
  const { rim, field } = place.world;
  context.strokeStyle = theme.border;
  context.lineWidth = widthOn(place, BORDER);
  context.beginPath();
  if (place.round) context.arc(place.x, place.y, rim * place.cell, 0, 2 * Math.PI);
  else context.rect(place.left, place.top, place.side, place.side);
  context.stroke();
  const heading = headingOf(place, sent);
  if (heading === null || !sent.sees) return;
  const angle = (-heading * Math.PI) / 4;
  context.save();
  // A field may be larger than the board.
  context.clip();
  context.strokeStyle = theme.field;
  context.lineWidth = widthOn(place, FIELD);
  context.beginPath();
  context.arc(place.x, place.y, field * place.cell, angle - Math.PI / 2, angle + Math.PI / 2);
  context.closePath();
  context.stroke();
  context.restore();
};

/**
 * The prey, and where it looks.
 * @param {CanvasRenderingContext2D} context
 * @param {Place} place
 * @param {Sent} sent
 */
export const drawPrey = (context, place, sent) => {
  const theme = /** @type {Theme} */ (sent.theme);
  // A tile is small: there the dot is smaller, and the arrow longer than that of a board as small.
  const isTile = place.heading !== null;
  const [dot, arrow] = isTile ? [2 * PREY, 2] : [PREY, 1];
  const [unit, heading] = [unitOf(place), headingOf(place, sent)];
  context.save();
  context.translate(place.x, place.y);
  context.scale(unit, unit);
  context.fillStyle = context.strokeStyle = theme.prey;
  context.beginPath();
  context.arc(0, 0, dot, 0, 2 * Math.PI);
  context.fill();
  if (heading !== null) {
    context.rotate((-heading * Math.PI) / 4);
    context.scale(arrow, arrow);
    context.lineWidth = widthOn(place, ARROW) / unit / arrow;
    context.lineCap = context.lineJoin = "round";
    context.beginPath();
    context.moveTo(TAIL, 0);
    context.lineTo(TIP, 0);
    context.moveTo(TIP - WING, -WING);
    context.lineTo(TIP, 0);
    context.lineTo(TIP - WING, WING);
    context.stroke();
  }
  context.restore();
};

/**
 * The outline of a cell, with a rim that sets it off.
 * @param {CanvasRenderingContext2D} context
 * @param {Place} place
 * @param {Sent} sent
 * @param {{east: number, north: number} | null} cell
 */
export const drawMark = (context, place, sent, cell) => {
  if (!cell || !place.has(cell.east, cell.north)) return;
  const theme = /** @type {Theme} */ (sent.theme);
  const [x, y] = place.to(cell.east, cell.north);
  const half = Math.max(place.cell / 2, MARK * unitOf(place));
  for (const [colour, width] of /** @type {const} */ ([
    [theme.unknown, 5.5],
    [theme.ink, 3],
  ])) {
    context.strokeStyle = colour;
    context.lineWidth = widthOn(place, width);
    context.strokeRect(x - half, y - half, 2 * half, 2 * half);
  }
};

/**
 * A word on a patch of the board's colour, with its middle at a place, or so near to it that none of
 * the word is cut.
 * @param {CanvasRenderingContext2D} context
 * @param {Place} place
 * @param {Sent} sent
 * @param {Word} word
 * @param {number} height of a line, in board units
 * @param {number} [most] pixels that it may take
 */
export const drawWord = (context, place, sent, [text, east, north], height, most = place.side) => {
  const theme = /** @type {Theme} */ (sent.theme);
  const size = Math.max(height * LETTERS * unitOf(place), SMALLEST * place.ratio);
  context.font = `${size}px ${place.font}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  const [at, y] = place.to(east, north);
  const room = most - PAD * size;
  const wide = Math.min(context.measureText(text).width, room) + PAD * size;
  const high = TALL * size;
  const x = Math.max(wide / 2, Math.min(at, place.sheet.width - wide / 2));
  context.beginPath();
  context.roundRect(x - wide / 2, y - high / 2, wide, high, ROUNDED * size);
  context.globalAlpha = PATCH;
  context.fillStyle = theme.unknown;
  context.fill();
  context.globalAlpha = 1;
  context.fillStyle = theme.ink;
  context.fillText(text, x, y, room);
};

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Place} whole
 * @param {Sent} sent
 */
export const drawWords = (context, whole, sent) => {
  const most = sent.tiles ? whole.side * whole.world.tiles.share : whole.side;
  const height = sent.tiles ? TILE_LABEL : LABEL;
  for (const word of sent.labels ?? []) drawWord(context, whole, sent, word, height, most);
};
