// @ts-check
// A board on a canvas: colours by state, lines and words over them, and the hunt. What is drawn is
// decided where it is sent from (app/player/boards.py); here it is put in its place.
import { Ground } from "./ground.js";
import { drawHunt } from "./hunt.js";
import { drawLines, drawPrey, drawWords } from "./over.js";
import { boardPlace, tilePlaces } from "./place.js";

/** @typedef {import("./sent.js").World} World */
/** @typedef {import("./sent.js").Sent} Sent */
/** @typedef {import("./place.js").Place} Place */

/** One board. Several may be on one page; they know nothing of each other. */
export class Board {
  /** How many pictures have been drawn. */
  drawn = 0;
  #canvas;
  #context;
  #ground = new Ground();
  /** @type {World | undefined} */
  #world;
  /** @type {Sent} */
  #sent = {};
  #due = 0;
  #observer;

  /** @param {HTMLCanvasElement} canvas whose size is given by a style; it is drawn as large as that */
  constructor(canvas) {
    this.#canvas = canvas;
    this.#context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    canvas.setAttribute("role", "img");
    this.#observer = new ResizeObserver(() => this.resize());
    this.#observer.observe(canvas);
  }

  /**
   * Take a world in, of which boards are to be shown.
   * @param {World} world as `world_sent` makes it
   */
  world(world) {
    this.#world = world;
    this.#ground.world(world);
    this.#soon();
  }

  /**
   * Show what has come; what it says nothing of stays.
   * @param {Sent} sent as `board_sent` makes it, or a part of that
   */
  show(sent) {
    this.#sent = { ...this.#sent, ...sent };
    // Colours on patterns are there only where they differ.
    if (sent.colours) {
      for (const pattern of /** @type {const} */ (["dots", "rising", "falling"])) {
        this.#sent[pattern] = sent[pattern];
      }
      this.#ground.colour(this.#sent);
    }
    this.#soon();
  }

  /**
   * Say what it is to those who cannot see it.
   * @param {string} text
   */
  describe(text) {
    if (this.#canvas.getAttribute("aria-label") !== text) this.#canvas.setAttribute("aria-label", text);
  }

  /** Draw as sharply as the canvas is large by now. */
  resize() {
    const { width, height } = this.#canvas.getBoundingClientRect();
    const ratio = window.devicePixelRatio || 1;
    const [wide, high] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (!wide || !high || (this.#canvas.width === wide && this.#canvas.height === high)) return;
    this.#canvas.width = wide;
    this.#canvas.height = high;
    // A canvas whose size is set is empty.
    this.draw();
  }

  /**
   * The cell at a place of the window, in cells east and north of the prey, and the heading in whose
   * picture it lies; null off the board.
   * @param {number} clientX
   * @param {number} clientY
   * @returns {{east: number, north: number, heading: number | null} | null}
   */
  cellAt(clientX, clientY) {
    const world = this.#world;
    if (!world) return null;
    const box = this.#canvas.getBoundingClientRect();
    const x = ((clientX - box.left) / box.width) * this.#canvas.width;
    const y = ((clientY - box.top) / box.height) * this.#canvas.height;
    for (const place of this.#places(world)) {
      const [east, north] = place.at(x, y);
      if (place.has(east, north)) return { east: Math.round(east), north: Math.round(north), heading: place.heading };
    }
    return null;
  }

  /** Draw now, and not with the next frame. */
  draw() {
    cancelAnimationFrame(this.#due);
    this.#due = 0;
    const [world, sent, context] = [this.#world, this.#sent, this.#context];
    const { width, height } = this.#canvas;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, width, height);
    if (!world || sent.world !== world.key || !sent.theme) return;
    const places = this.#places(world);
    this.#ground.draw(context, places, sent);
    // Lines over another view would mislead.
    const isOver = sent.over === sent.view;
    const whole = sent.tiles ? boardPlace(world, width, height, false) : places[0];
    if (isOver) drawLines(context, whole, sent);
    for (const place of places) drawPrey(context, place, sent, world);
    if (sent.hunt) drawHunt(context, whole, sent);
    if (isOver) drawWords(context, whole, sent);
    this.drawn += 1;
  }

  /** Draw nothing any more. */
  remove() {
    cancelAnimationFrame(this.#due);
    this.#observer.disconnect();
  }

  #soon() {
    this.#due ||= requestAnimationFrame(() => this.draw());
  }

  /**
   * Where the board lies, or each of its tiles.
   * @param {World} world
   */
  #places(world) {
    const { width, height } = this.#canvas;
    return this.#sent.tiles
      ? tilePlaces(world, width, height)
      : [boardPlace(world, width, height, Boolean(this.#sent.round))];
  }
}
