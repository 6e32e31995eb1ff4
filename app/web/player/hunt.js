// @ts-check
// A hunt on a board: the predator, the way that it has come, and where the last hunts ended.
import { drawPrey, drawWord, trace, unitOf, widthOn } from "./over.js";

/** @typedef {import("./sent.js").Sent} Sent */
/** @typedef {import("./place.js").Place} Place */
/** @typedef {import("./sent.js").Shape} Shape */

/** In board units. */
const [PREDATOR, HALO, END] = [0.13, 0.17, 0.1];
const RIM = 1.5;
const TRAIL = 3;
const TAG = 0.42;
/** The trail fades in so many steps. */
const STEPS = 12;

/**
 * @param {CanvasRenderingContext2D} context
 * @param {number} x
 * @param {number} y
 * @param {number} radius
 * @param {Shape} shape
 * @param {string} colour
 */
const dot = (context, x, y, radius, shape, colour) => {
  context.fillStyle = colour;
  context.beginPath();
  if (shape === "circle") context.arc(x, y, radius, 0, 2 * Math.PI);
  else if (shape === "square") context.rect(x - radius, y - radius, 2 * radius, 2 * radius);
  else {
    context.moveTo(x - radius, y);
    context.lineTo(x, y - radius);
    context.lineTo(x + radius, y);
    context.lineTo(x, y + radius);
    context.closePath();
  }
  context.fill();
};

/** @param {string} colour as `rgb(r,g,b)` */
const partsOf = (colour) => (colour.match(/\d+/g) ?? []).map(Number);

/**
 * A colour between two.
 * @param {string} from
 * @param {string} to
 * @param {number} share
 */
const between = (from, to, share) => {
  const [a, b] = [partsOf(from), partsOf(to)];
  return `rgb(${a.map((part, i) => Math.round(part + (b[i] - part) * share)).join(",")})`;
};

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Place} place
 * @param {Sent} sent
 */
const drawTrail = (context, place, sent) => {
  const { trail, ended } = /** @type {import("./sent.js").Hunt} */ (sent.hunt);
  const theme = /** @type {import("./sent.js").Theme} */ (sent.theme);
  const last = trail.length / 2 - 1;
  if (last < 1) return;
  context.lineCap = context.lineJoin = "round";
  context.lineWidth = widthOn(place, TRAIL);
  const pieces = ended ? 1 : Math.min(STEPS, last);
  for (let piece = 0; piece < pieces; piece++) {
    const [from, to] = [Math.round((piece * last) / pieces), Math.round(((piece + 1) * last) / pieces)];
    context.strokeStyle = ended?.colour ?? between(theme.unknown, theme.predator, (piece + 1) / pieces);
    context.beginPath();
    trace(context, place, trail.slice(2 * from, 2 * to + 2));
    context.stroke();
  }
};

/**
 * The last hunts, the prey in each board, and over it the predator.
 * @param {CanvasRenderingContext2D} context
 * @param {Place} place the whole board
 * @param {Place[]} each board of it
 * @param {Sent} sent
 */
export const drawHunt = (context, place, each, sent) => {
  const theme = /** @type {import("./sent.js").Theme} */ (sent.theme);
  const { hunt } = sent;
  const unit = unitOf(place);
  if (hunt) drawTrail(context, place, sent);
  for (const [east, north] of hunt?.ends ?? []) {
    dot(context, ...place.to(east, north), END * RIM * unit, "circle", theme.unknown);
  }
  for (const [east, north, shape, colour] of hunt?.ends ?? []) {
    dot(context, ...place.to(east, north), END * unit, shape, colour);
  }
  for (const one of each) drawPrey(context, one, sent);
  if (!hunt?.predator) return;
  const [x, y] = place.to(...hunt.predator);
  dot(context, x, y, HALO * unit, "circle", theme.unknown);
  dot(context, x, y, PREDATOR * unit, "circle", theme.predator);
  if (hunt.ended) dot(context, x, y, END * unit, hunt.ended.shape, hunt.ended.colour);
  for (const word of hunt.words) drawWord(context, place, sent, word, TAG);
};
