// @ts-check
// Where one looks in a recording, and how it is played: what the lab does with what the time bar sends,
// done in the page. Pure: time is given from outside.

/**
 * @typedef {import("./film.js").Shot} Shot
 * @typedef {{step: number, trial: number}} Place
 * @typedef {{number: number, parent: number | null, fork: number, events: number[]}} Line `events` has
 *   the steps of what happened, ascending
 */

/** So long all of it plays at the rate 1. */
const WHOLE_S = 30;
const LEAST_MOMENTS_PER_S = 5;
/** @type {Array<[number, string]>} */
const RATES = [
  [0.25, "a quarter as fast"],
  [0.5, "half as fast"],
  [1, "whole run in 30 s"],
  [2, "twice as fast"],
  [4, "4 times as fast"],
];
/** Moments that keys of trials go on. */
const MANY = 10;

/**
 * The moments of each line by their places in the film: those of the line that it left, and its own.
 * @param {Line[]} lines
 * @param {Shot[]} shots
 */
const courses = (lines, shots) => {
  /** @type {Map<number, number[]>} */
  const found = new Map();
  const places = shots.map((_, place) => place);
  for (const { number, parent, fork } of lines) {
    const before = parent === null ? [] : (found.get(parent) ?? []);
    const own = places.filter((place) => shots[place].line === number);
    found.set(number, [...before.filter((place) => shots[place].step < fork), ...own]);
  }
  return found;
};

export class Walk {
  /**
   * @param {Line[]} lines parents before those that branched off them
   * @param {number} line that is shown first
   * @param {Shot[]} shots
   */
  constructor(lines, line, shots) {
    this.lines = lines;
    this.shots = shots;
    this.courses = courses(lines, shots);
    this.line = line;
    /** Which moment of the line, exactly, as it plays. */
    this.at = this.course.length - 1;
    this.direction = 0;
    this.rate = 1;
    this.stops = false;
    /** Its line, and its place in the film. @type {{line: number, shot: number} | null} */
    this.a = null;
    /** Its ends, as places among the moments of the line. @type {[number, number] | null} */
    this.loop = null;
  }

  get course() {
    return /** @type {number[]} */ (this.courses.get(this.line));
  }

  /** The place in the film of the moment that is looked at. */
  get shot() {
    return this.course[Math.round(this.at)];
  }

  /** @param {number} shot @returns {Place} */
  #place(shot) {
    const { step, trial } = this.shots[shot];
    return { step, trial };
  }

  /** What the time bar is told of it. */
  get moment() {
    const loop = this.loop && {
      a: this.#place(this.course[this.loop[0]]),
      b: this.#place(this.course[this.loop[1]]),
    };
    return {
      ...{ line: this.line, ...this.#place(this.shot), live: false, behind_trials: 0, behind_steps: 0 },
      ...{ playing: this.direction !== 0, direction: this.direction || 1, rate: this.rate, rates: RATES },
      ...{ a: this.a && { line: this.a.line, ...this.#place(this.a.shot) }, loop },
      ...{ holds: false, stops: this.stops, until_step: null, watched: null },
    };
  }

  /** @param {number} at */
  #go(at) {
    this.at = Math.min(Math.max(at, 0), this.course.length - 1);
  }

  /**
   * The moment of the line that is nearest.
   * @param {"step" | "trial"} unit
   * @param {number} number
   */
  #nearest(unit, number) {
    const away = (/** @type {number} */ at) => Math.abs(this.shots[this.course[at]][unit] - number);
    let nearest = 0;
    this.course.forEach((_, at) => {
      if (away(at) < away(nearest)) nearest = at;
    });
    return nearest;
  }

  /** Stand still at the moment that is nearest to a step or to a trial. @param {"step" | "trial"} unit @param {number} number */
  seek(unit, number) {
    this.direction = 0;
    this.#go(this.#nearest(unit, number));
  }

  end() {
    this.direction = 0;
    this.#go(Infinity);
  }

  /** Look at another line, at the same step if that has it. @param {number} line */
  look(line) {
    if (!this.courses.has(line) || line === this.line) return;
    const { step } = this.shots[this.shot];
    this.line = line;
    this.loop = null;
    this.#go(this.#nearest("step", step));
  }

  /** The steps of what happened in the line. */
  get #events() {
    return this.lines.find(({ number }) => number === this.line)?.events ?? [];
  }

  /**
   * @param {"steps" | "trials" | "events"} unit
   * @param {number} n
   */
  by(unit, n) {
    this.direction = 0;
    if (unit !== "events") return this.#go(Math.round(this.at) + n * (unit === "trials" ? MANY : 1));
    const { step } = this.shots[this.shot];
    const events = this.#events;
    const next = n > 0 ? events.find((each) => each > step) : events.findLast((each) => each < step);
    if (next !== undefined) this.#go(this.#nearest("step", next));
    else this.#go(n > 0 ? Infinity : 0);
  }

  /** @param {number} direction */
  play(direction) {
    const last = this.course.length - 1;
    // From its end it plays once more.
    if (direction > 0 && this.at >= last && !this.loop) this.at = 0;
    if (direction < 0 && this.at <= 0 && !this.loop) this.at = last;
    this.at = Math.round(this.at);
    this.direction = direction;
  }

  setA() {
    this.a = { line: this.line, shot: this.shot };
    this.loop = null;
  }

  /**
   * Play what lies between A and here again and again, or no longer; what cannot be is said.
   * @param {boolean} on
   */
  setLoop(on) {
    this.loop = null;
    if (!on) return "";
    const first = this.a?.line === this.line ? this.course.indexOf(this.a.shot) : -1;
    if (first < 0) return "Set A first, at the moment at which the loop is to begin.";
    const here = Math.round(this.at);
    if (here === first) return "Go to another moment than A: the loop is to end there.";
    this.loop = [Math.min(first, here), Math.max(first, here)];
    return "";
  }

  /** Play on for so many seconds. @param {number} seconds */
  go(seconds) {
    if (!this.direction) return;
    const last = this.course.length - 1;
    const speed = Math.max(last / WHOLE_S, LEAST_MOMENTS_PER_S) * this.rate;
    const before = Math.round(this.at);
    let after = this.at + this.direction * speed * seconds;
    const event = this.stops ? this.#passed(before, Math.round(after)) : undefined;
    if (event !== undefined) {
      this.direction = 0;
      return this.#go(event);
    }
    if (this.loop) {
      const [first, until] = this.loop;
      if (this.direction > 0 && after >= until) after = first;
      else if (this.direction < 0 && after <= first) after = until;
    }
    if (after <= 0 || after >= last) this.direction = 0;
    this.#go(after);
  }

  /** The first moment at which something happened on the way from one to another. @param {number} before @param {number} after */
  #passed(before, after) {
    const events = new Set(this.#events);
    const way = Math.sign(after - before);
    for (let at = before + way; way && at !== after + way; at += way)
      if (events.has(this.shots[this.course[at]]?.step)) return at;
    return undefined;
  }
}
