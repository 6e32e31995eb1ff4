// @ts-check
// The one axis: between trials, steps and shares of its length, for either unit. Pure.

/**
 * @typedef {{
 *   unit: "trials" | "steps",
 *   start?: number,
 *   end: number,
 *   trials: number[],
 *   steps: number[],
 *   pace: number,
 *   ticks: Array<{at: number, text: string}>,
 * }} Axis `start` and `end`, in its unit, are what its ends stand for, from 0 on if nothing else is
 *   said; `trials[i]` began after `steps[i]` steps; `pace` is how many steps a trial ahead is taken to have
 */

/**
 * Piecewise linear through points that rise, beyond the last with a slope, and level before the first.
 * @param {number[]} xs
 * @param {number[]} ys
 * @param {number} slope
 * @param {number} x
 */
const along = (xs, ys, slope, x) => {
  const last = xs.length - 1;
  if (x >= xs[last]) return ys[last] + (x - xs[last]) * slope;
  let low = 0;
  let high = last;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (xs[middle] <= x) low = middle;
    else high = middle;
  }
  const share = (x - xs[low]) / (xs[high] - xs[low] || 1);
  return ys[low] + Math.max(share, 0) * (ys[high] - ys[low]);
};

/** @param {number} share */
const within = (share) => Math.min(Math.max(share, 0), 1);

/**
 * Where something lies that is told in the axis's unit.
 * @param {Axis} axis
 * @param {number} at
 */
const placeOf = ({ start = 0, end }, at) => within((at - start) / (end - start));

/**
 * What lies at a place, in the axis's unit.
 * @param {Axis} axis
 * @param {number} share
 */
const unitsAt = ({ start = 0, end }, share) => start + within(share) * (end - start);

/**
 * Steps made when a trial begins, be it ahead.
 * @param {Axis} axis
 * @param {number} trial
 */
export const stepOfTrial = (axis, trial) => along(axis.trials, axis.steps, axis.pace, trial);

/**
 * Trials, with their parts, that so many steps make.
 * @param {Axis} axis
 * @param {number} step
 */
export const trialOfStep = (axis, step) => along(axis.steps, axis.trials, 1 / axis.pace, step);

/**
 * Where a trial begins, as a share of the axis: nothing lies beyond its ends.
 * @param {Axis} axis
 * @param {number} trial
 */
export const shareOfTrial = (axis, trial) =>
  placeOf(axis, axis.unit === "trials" ? trial : stepOfTrial(axis, trial));

/**
 * @param {Axis} axis
 * @param {number} step
 */
export const shareOfStep = (axis, step) =>
  placeOf(axis, axis.unit === "steps" ? step : trialOfStep(axis, step));

/**
 * Where a moment lies of which trial and step are known.
 * @param {Axis} axis
 * @param {{trial: number, step: number}} place
 */
export const shareOf = (axis, { trial, step }) =>
  placeOf(axis, axis.unit === "trials" ? trial : step);

/**
 * The trial that is nearest to a place.
 * @param {Axis} axis
 * @param {number} share
 */
export const trialAt = (axis, share) => {
  const place = unitsAt(axis, share);
  return Math.round(axis.unit === "trials" ? place : trialOfStep(axis, place));
};

/**
 * The step that is nearest to a place.
 * @param {Axis} axis
 * @param {number} share
 */
export const stepAt = (axis, share) => {
  const place = unitsAt(axis, share);
  return Math.round(axis.unit === "steps" ? place : stepOfTrial(axis, place));
};

/**
 * The roundest number near a place: a hand cannot mean one more exactly than it can point.
 * @param {number} at
 * @param {number} apart what lies between two pixels
 */
export const roundest = (at, apart) => {
  const whole = 10 ** Math.ceil(Math.log10(Math.max(apart, 1)));
  const unit = [whole / 5, whole / 2, whole].find((each) => each >= apart) ?? whole;
  return unit < 1 ? Math.round(at) : Math.round(at / unit) * unit;
};
