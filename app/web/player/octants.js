// @ts-check
// The eight octants round the prey on a board's canvas: which of them a cell is in, and what was guessed
// and came of it, as app/page/lesson/board.py draws it on the lab's own board.

import { drawWord, unitOf, widthOn } from "./over.js";

/** @typedef {import("./place.js").Place} Place */
/** @typedef {import("./sent.js").Sent} Sent */

/** From straight ahead on, counter-clockwise, as headings are numbered. */
export const OCTANTS = ["e", "ne", "n", "nw", "w", "sw", "s", "se"];
const WIDE = Math.PI / 4;
/** Radius at which they begin, in board units, and how far a guess reaches, as a share of the board's. */
const [INNER, OUTER] = [0.42, 0.9];
/** How far the sides of a guess lie within it, and how far apart its hatch is, in board units. */
const [INSET, APART] = [0.06, 0.42];
const [GUESS, RIM, HATCH, BORDER] = [4.5, 8, 1.5, 1.5];
/** How strongly the run's octants are filled, the band along their rim, and from where to where that is. */
const [RUN, BAND] = [0.2, 0.85];
const [FROM, UNTIL] = [0.92, 0.985];
/** The same of a class: what nobody chose, what all did, and from where to where that is drawn. */
const [FAINTEST, STRONGEST] = [0.1, 0.75];
const HEAT = { light: "rgb(192 86 0)", dark: "rgb(255 169 77)", from: 0.14, until: 0.56 };
/** Where names and numbers stand, and how high a line of them is, in board units. */
const [NAMES_AT, SHARES_AT, NAME, SHARE] = [0.74, 0.37, 0.41, 0.5];
const BLUE = { light: "rgb(0 50 170)", dark: "rgb(110 190 255)" };

/**
 * @typedef {{
 *   guess: string[], locked: boolean, run: string[] | null,
 *   shares: Record<string, number> | null, names: Record<string, string>,
 *   percent: (share: number) => string,
 * }} Asked `run` is what it came to, and `shares` how many of a class chose each, once that may be seen
 */

/**
 * The octant of a cell, null where the prey stands.
 * @param {{east: number, north: number}} cell
 * @param {number} heading where the prey looks
 */
export const octantAt = ({ east, north }, heading = 0) => {
  if (!east && !north) return null;
  const turned = Math.floor(Math.atan2(north, east) / WIDE - heading + 0.5);
  return OCTANTS[((turned % 8) + 8) % 8];
};

/**
 * Put an octant, or the part of it between two radii, into the path.
 * @param {CanvasRenderingContext2D} context
 * @param {Place} place
 * @param {number} angle its middle
 * @param {[number, number]} radii in pixels
 * @param {number} inset
 */
const trace = (context, place, angle, [inner, outer], inset = 0) => {
  const [near, far] = [inner, outer].map((radius) => WIDE / 2 - Math.asin(Math.min(inset / radius, 1)));
  context.beginPath();
  // Down is more on a canvas.
  context.arc(place.x, place.y, outer, -angle - far, -angle + far);
  context.arc(place.x, place.y, inner, -angle + near, -angle - near, true);
  context.closePath();
};

/**
 * @param {CanvasRenderingContext2D} context
 * @param {Place} place
 * @param {number} apart
 */
const hatch = (context, place, apart) => {
  const reach = place.side;
  context.beginPath();
  for (let away = -reach; away < reach; away += apart) {
    context.moveTo(place.x - reach + away, place.y + reach + away);
    context.lineTo(place.x + reach + away, place.y - reach + away);
  }
};

/**
 * Draw what is asked over a board.
 * @param {CanvasRenderingContext2D} context
 * @param {Place} place
 * @param {Sent} sent
 * @param {number} heading where the prey looks
 * @param {Asked} asked
 */
export const drawOctants = (context, place, sent, heading, { guess, locked, run, shares, names, percent }) => {
  const { theme } = sent;
  if (!theme) return;
  const unit = unitOf(place);
  const radius = place.world.rim * place.cell;
  const [inner, outer] = [INNER * unit, OUTER * radius];
  const scheme = theme.dark ? "dark" : "light";
  const angles = OCTANTS.map((_, index) => (index + heading) * WIDE);
  context.save();
  OCTANTS.forEach((octant, index) => {
    const angle = angles[index];
    context.fillStyle = BLUE[scheme];
    if (run?.includes(octant)) {
      for (const [strength, from, until] of [
        [RUN, inner, radius],
        [BAND, FROM * radius, UNTIL * radius],
      ]) {
        context.globalAlpha = strength;
        trace(context, place, angle, [from, until]);
        context.fill();
      }
    }
    if (shares) {
      context.fillStyle = HEAT[scheme];
      context.globalAlpha = FAINTEST + (shares[octant] ?? 0) * (STRONGEST - FAINTEST);
      trace(context, place, angle, [HEAT.from * radius, HEAT.until * radius]);
      context.fill();
    }
    context.globalAlpha = 1;
    const side = angle + WIDE / 2;
    context.beginPath();
    context.moveTo(place.x + inner * Math.cos(side), place.y - inner * Math.sin(side));
    context.lineTo(place.x + radius * Math.cos(side), place.y - radius * Math.sin(side));
    context.strokeStyle = theme.border;
    context.lineWidth = widthOn(place, BORDER);
    context.stroke();
  });
  for (const octant of guess) {
    const angle = angles[OCTANTS.indexOf(octant)];
    trace(context, place, angle, [inner, outer], INSET * unit);
    context.save();
    context.clip();
    hatch(context, place, APART * unit * Math.SQRT2);
    context.strokeStyle = theme.ink;
    context.lineWidth = widthOn(place, HATCH);
    context.stroke();
    context.restore();
    trace(context, place, angle, [inner, outer], INSET * unit);
    for (const [colour, width] of /** @type {const} */ ([
      [theme.unknown, RIM],
      [theme.ink, GUESS],
    ])) {
      context.strokeStyle = colour;
      context.lineWidth = widthOn(place, width);
      context.stroke();
    }
  }
  const cells = place.world.rim;
  OCTANTS.forEach((octant, index) => {
    const [east, north] = [Math.cos(angles[index]) * cells, Math.sin(angles[index]) * cells];
    if (!locked) drawWord(context, place, sent, [names[octant], NAMES_AT * east, NAMES_AT * north], NAME);
    if (!shares) return;
    const share = percent(shares[octant] ?? 0);
    drawWord(context, place, sent, [share, SHARES_AT * east, SHARES_AT * north], SHARE);
  });
  context.restore();
};
