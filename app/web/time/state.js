// @ts-check
// What the time bar shows: all that is drawn is a function of this.

import { drawing } from "../player/drawing.js";

/**
 * A moment of one line. Trials are those that run then.
 * @typedef {{step: number, trial: number}} Place
 *
 * What lies along the axis of a bar, seldom sent anew.
 * @typedef {import("./axis.js").Axis} Axis
 * @typedef {{at: number[], reward: number[]}} Points places are shares of the axis
 * @typedef {{
 *   skill: string, first: number, known: number, until: number | null, below: number, met: boolean,
 *   trials: number[], values: number[], fires: number[],
 *   ends: [number, number], what: [string, string], short: [string, string], long: string,
 * }} Rule what a rule watches: `values` are known before `trials`, where it would be met in `fires`, or
 *   never, which is -1; the first window is over in `known`, and the skill joined in `until`
 * @typedef {{key: string, first: number, until: number | null, kind: "forced" | "taught" | "frozen"}} Band
 * @typedef {{
 *   at: number, name: string, more: string, before: boolean, room: number,
 *   hint: string, note: number | null,
 * }} Mark `note` is its number in `notes`, if somebody wrote it
 * @typedef {{first: number, until: number | null, ahead: boolean}} Stretch
 * @typedef {{
 *   key: string, id: string, kind: "join" | "forced" | "taught" | "frozen", half: "whole" | "upper" | "lower",
 *   first: number, until: number | null, probability: number | null, what: string,
 *   idle: boolean, hand: boolean, editable: boolean, chosen: boolean, hint: string,
 * }} Piece `until` is null of what nobody has ended; `key` tells blocks apart, `id` is what
 *   it is edited by
 * @typedef {{
 *   of: string[], before: string, text: string, after: string,
 *   at: number, side: "before" | "after" | "within", room: number,
 * }} Label `of` has the keys of the blocks that it is said of
 * @typedef {{
 *   name: string, skill: string, presence: Stretch[], pieces: Piece[], labels: Label[],
 * }} Lane
 * @typedef {{step: number, trial: number, kind: string, text: string}} Happening
 * @typedef {{number: number, step: number, trial: number, text: string}} Note a mark with its text
 * @typedef {{
 *   line: number, parent: number | null, name: string, fork: Place, until: Place,
 *   reward: string, digest: string, live: boolean, growing: boolean, hint: string,
 * }} Line
 * @typedef {{
 *   line: number, live: boolean, recorded: boolean, axis: Axis, end: Place,
 *   legend: Array<{kind: string, text: string, hint: string}>,
 *   rewards: [number, number], levels: Array<[number, string]>,
 *   learned: Points, greedy: Points, gaps: boolean[], ghost: Points | null,
 *   rules: Rule[], bands: Band[], marks: Mark[], lanes: Lane[],
 *   happenings: Happening[], notes: Note[], lines: Line[],
 *   units: Array<{unit: string, name: string, hint: string}>,
 *   colours: {light: Record<string, string>, dark: Record<string, string>},
 * }} Bar `end` is how far the line is known; of what is `recorded` all is, and nothing can be changed
 *
 * What changes with each frame.
 * @typedef {{
 *   line: number, step: number, trial: number, live: boolean,
 *   behind_trials: number, behind_steps: number,
 *   playing: boolean, direction: number, rate: number, rates: Array<[number, string]>,
 *   a: (Place & {line?: number}) | null, loop: {a: Place, b: Place} | null,
 *   holds: boolean, stops: boolean, until_step: number | null,
 *   watched: {trial: number, value: number, fires: number} | null,
 * }} Moment `watched` is what the rule that is waited for watches there
 *
 * What is asked on the bar: at which trial, or how the curve will go from one trial to another. `run` and
 * what is of other runs is there once it may be seen. Points are trials and rewards.
 * @typedef {[number, number]} Point
 * @typedef {{
 *   kind: "moment", id: string, language: string, from: number, to: number | null, guess: number | null, locked: boolean,
 *   run: number | null, twenty: number[], runs: number,
 * }} MomentAsked
 * @typedef {{
 *   kind: "sketch", id: string, language: string, from: number, to: number, at: number[], handles: Point[] | null,
 *   locked: boolean, run: Point[], band: {at: number[], low: number[], high: number[]} | null,
 * }} SketchAsked `at` has the trials of the handles, which are null as long as nothing was drawn
 *
 * A block while a hand has it: what is not there is as it was.
 * @typedef {{id: string, at?: number, trials?: number, probability?: number}} Draft
 */

/** Of a name and of the text of a mark; the lab takes no longer one. */
export const MOST_CHARACTERS = 80;

/**
 * `bar` and `moment` come from the lab, which never touches the `draft`: that is the hand's until it
 * lets go. `moment` may be set here, too, so that the playhead is under the hand at once.
 * While `scrub` is there, a hand holds the playhead at that place; while something is `held`, a newer
 * bar waits, since no axis may move under a hand. What is asked is drawn by a page that can ask (guess.js).
 * @type {{
 *   bar: Bar | null, moment: Moment | null, draft: Draft | null,
 *   scrub: Place | null, held: boolean, ask: MomentAsked | SketchAsked | null,
 * }}
 */
export const state = {
  bar: null,
  moment: null,
  draft: null,
  scrub: null,
  held: false,
  ask: null,
};

export const { whenChanged, changed } = drawing();
