// @ts-check
// The eight parts of the board round the prey, as it lies there: the prey in the middle looks east.

import { OCTANTS } from "../player/octants.js";

const SVG = "http://www.w3.org/2000/svg";
const HALF = Math.PI / OCTANTS.length;
const SIZE = 100;
/** Between parts, so that one sees where they end. */
const GAP = 0.025;
const PREY = 13;

/**
 * @param {string} name
 * @param {Record<string, string | number>} attributes
 */
export const svgElement = (name, attributes = {}) => {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, `${value}`);
  return made;
};

/** @param {number} angle @param {number} radius */
const at = (angle, radius) => `${(radius * Math.cos(angle)).toFixed(2)} ${(-radius * Math.sin(angle)).toFixed(2)}`;

/**
 * The outline of a part between two radii.
 * @param {number} index
 * @param {number} inner
 * @param {number} outer
 */
export const wedge = (index, inner, outer) => {
  const [from, to] = [(2 * index - 1) * HALF + GAP, (2 * index + 1) * HALF - GAP];
  return `M${at(from, inner)}L${at(from, outer)}A${outer} ${outer} 0 0 0 ${at(to, outer)}L${at(to, inner)}A${inner} ${inner} 0 0 1 ${at(from, inner)}Z`;
};

/** The middle of a part. @param {number} index @param {number} radius */
export const middle = (index, radius) => {
  const angle = 2 * index * HALF;
  return { x: radius * Math.cos(angle), y: -radius * Math.sin(angle) };
};

/** A picture with nothing but the prey, which looks to the right, and sees what is there. */
export const compass = () => {
  const svg = svgElement("svg", { viewBox: `${-SIZE - 2} ${-SIZE - 2} ${2 * SIZE + 4} ${2 * SIZE + 4}`, class: "compass" });
  svg.append(
    svgElement("circle", { r: PREY - 5, class: "prey" }),
    svgElement("path", { d: `M2 ${-3.5}L9 0L2 3.5Z`, class: "looks" }),
  );
  return svg;
};

export const RADII = { prey: PREY, outer: SIZE };
