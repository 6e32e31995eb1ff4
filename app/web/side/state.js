// @ts-check
// What the frame with runs side by side shows: all that is drawn is a function of this.

import { drawing } from "../player/drawing.js";

/**
 * How a run's line is drawn, whatever is shown of it; dashes are in pixels.
 * @typedef {{light: string, dark: string, width: number, dashes: number[]}} Look
 * @typedef {{name: string, seed: number, about: string, look: Look}} Run
 * @typedef {{runs: Run[]}} Race
 * @typedef {{at: number[], reward: number[]}} Points places are shares of the axis
 * @typedef {{
 *   axis: import("../time/axis.js").Axis, rewards: [number, number], levels: Array<[number, string]>,
 *   curves: Points[], events: Array<{step: number, kind: string, text: string, run: number}>,
 * }} Curves
 * @typedef {{
 *   trial: string, reward: string, success: string, greedy: string, measured: string,
 *   stand: string, digest: string, leads: boolean,
 * }} Reading
 * @typedef {{
 *   step: number, end: number, live: boolean, playing: boolean, finished: boolean, direction: number,
 *   rate: number, rates: Array<[number, string]>, error: string | null, preparing: boolean,
 * }} Moment `end` is how far the runs have come
 * @typedef {{
 *   standing: string, runs: Reading[], speed: number, speeds: Array<[number, string]>, pace: string,
 * }} Readings `speed` is 0 as fast as it goes
 * @typedef {{layer: string, html: string, captions: string[]}} Legend
 * @typedef {{
 *   one: number, other: number, shown: boolean, text: string, step: number | null, legend: string,
 *   caption: string,
 * }} Comparison
 * @typedef {{
 *   rows: Array<{what: string, values: string[], hint: string}> | null, east: number, north: number,
 * }} Cell
 * @typedef {{
 *   lines: Array<{line: number, name: string}>, presets: string[], preset: string, seed: number,
 * }} Choice
 */

/**
 * @type {{
 *   race: Race | null, curves: Curves | null, moment: Moment | null, readings: Readings | null, legend: Legend | null,
 *   compare: Comparison | null, cell: Cell | null, choice: Choice | null,
 *   scrub: number | null, choosing: boolean,
 * }} while `scrub` is there, a hand holds the playhead at that step
 */
export const state = {
  race: null,
  curves: null,
  moment: null,
  readings: null,
  legend: null,
  compare: null,
  cell: null,
  choice: null,
  scrub: null,
  choosing: false,
};

export const { whenChanged, changed } = drawing();

/** Whether there is something to look at. */
export const isRacing = () => (state.race?.runs.length ?? 0) > 0;
