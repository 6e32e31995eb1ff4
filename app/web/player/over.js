// @ts-check
// What lies over the colours of a board: its border, lines, the prey, and words.

/** @typedef {import("./sent.js").World} World */
/** @typedef {import("./sent.js").Sent} Sent */
/** @typedef {import("./place.js").Place} Place */

/** Pixels along each side of the board for which the widths of lines are meant. */
const WIDTHS_FOR = 640;
/** The board of the lab is so many units wide, in which sizes of things on it are given. */
const UNITS = 12;
const FIELD = 3;
const ARROW = 4;
const BORDER = 2;
/** Along an arrow that shows where the prey looks: where it begins and ends, and its wings. */
const [TAIL, TIP, WING] = [0.12, 0.62, 0.2];
const PREY = 0.13;
const LABEL = 0.34;
const TILE_LABEL = 0.29;

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
export const widthOn = (place, width) => {
  const ratio = window.devicePixelRatio || 1;
  return Math.max(width * Math.min(Math.max(place.side / ratio / WIDTHS_FOR, 0.4), 1.6), 0.6) * ratio;
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
 * @param {CanvasRenderingContext2D} context
 * @param {Place} whole
 * @param {Sent} sent
 */
export const drawLines = (context, whole, sent) => {
  context.lineCap = context.lineJoin = "round";
  for (const { colour, width, points } of sent.lines ?? []) {
    context.beginPath();
    context.strokeStyle = colour;
    context.lineWidth = widthOn(whole, width);
    for (const piece of points) trace(context, whole, piece);
    context.stroke();
  }
};

/**
 * The border of the board, the prey in its middle, where it looks and what it sees.
 * @param {CanvasRenderingContext2D} context
 * @param {Place} place
 * @param {Sent} sent
 * @param {World} world
 */
export const drawPrey = (context, place, sent, world) => {
  const theme = /** @type {import("./sent.js").Theme} */ (sent.theme);
  const unit = unitOf(place);
  const heading = place.heading ?? sent.prey ?? null;
  const turns = sent.prey !== null && heading !== null;
  context.strokeStyle = theme.border;
  context.lineWidth = widthOn(place, BORDER);
  context.beginPath();
  if (place.round) context.arc(place.x, place.y, world.rim * place.cell, 0, 2 * Math.PI);
  else context.rect(place.left, place.top, place.side, place.side);
  context.stroke();
  const angle = turns ? (-heading * Math.PI) / 4 : 0;
  if (turns && sent.sees) {
    context.strokeStyle = theme.field;
    context.lineWidth = widthOn(place, FIELD);
    context.beginPath();
    context.arc(place.x, place.y, world.field * place.cell, angle - Math.PI / 2, angle + Math.PI / 2);
    context.closePath();
    context.stroke();
  }
  context.fillStyle = theme.prey;
  context.beginPath();
  context.arc(place.x, place.y, PREY * unit, 0, 2 * Math.PI);
  context.fill();
  if (!turns) return;
  // In a tile it is longer, or it would be a dot.
  const long = (place.heading === null ? 1 : 2) * unit;
  context.save();
  context.translate(place.x, place.y);
  context.rotate(angle);
  context.strokeStyle = theme.prey;
  context.lineWidth = widthOn(place, ARROW);
  context.lineCap = context.lineJoin = "round";
  context.beginPath();
  context.moveTo(TAIL * long, 0);
  context.lineTo(TIP * long, 0);
  context.moveTo((TIP - WING) * long, -WING * long);
  context.lineTo(TIP * long, 0);
  context.lineTo((TIP - WING) * long, WING * long);
  context.stroke();
  context.restore();
};

/**
 * A word on a patch of the board's colour, with its middle at a place.
 * @param {CanvasRenderingContext2D} context
 * @param {Place} place
 * @param {Sent} sent
 * @param {[string, number, number]} label
 * @param {number} height of a line, in board units
 */
export const drawWord = (context, place, sent, [text, east, north], height) => {
  if (!text) return;
  const theme = /** @type {import("./sent.js").Theme} */ (sent.theme);
  const ratio = window.devicePixelRatio || 1;
  const size = Math.max(height * unitOf(place) * 0.72, 9 * ratio);
  context.font = `${size}px system-ui, sans-serif`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  const [x, y] = place.to(east, north);
  const wide = context.measureText(text).width + size * 0.7;
  const high = size * 1.35;
  context.beginPath();
  context.roundRect(x - wide / 2, y - high / 2, wide, high, size * 0.3);
  context.globalAlpha = 0.88;
  context.fillStyle = theme.unknown;
  context.fill();
  context.globalAlpha = 1;
  context.fillStyle = theme.ink;
  context.fillText(text, x, y);
};

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Place} whole
 * @param {Sent} sent
 */
export const drawWords = (context, whole, sent) => {
  for (const label of sent.labels ?? []) drawWord(context, whole, sent, label, sent.tiles ? TILE_LABEL : LABEL);
};
