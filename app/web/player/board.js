// @ts-check
// A board on a canvas: colours by state, lines and words over them, and the hunt. What is drawn is
// decided where it is sent from (app/player/boards.py); here it is put in its place.
import { Ground } from "./ground.js";
import { drawHunt } from "./hunt.js";
import { drawBorder, drawLines, drawMark, drawWords } from "./over.js";
import { boardPlace, tilePlaces, tilesPlace } from "./place.js";

/** @typedef {import("./sent.js").World} World */
/** @typedef {import("./sent.js").Sent} Sent */
/** @typedef {import("./sent.js").Line} Line */
/** @typedef {import("./place.js").Place} Place */

/** @typedef {(context: CanvasRenderingContext2D, place: Place, sent: Sent) => void} Above */

/** Pixels of the canvas for each of the page on paper, which is finer than a screen. */
const PRINTED = 4;

/**
 * Whether its lines and words are of what is seen: over another view they would mislead.
 * @param {Sent} sent
 */
const isOver = (sent) => sent.over === sent.view;

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
  /** @type {{east: number, north: number} | null} */
  #marked = null;
  /** What somebody else draws over a whole board. @type {Above | null} */
  #above = null;
  /** What was drawn last over the colours. @type {{canvas: HTMLCanvasElement, lines?: Line[], looks: string}} */
  #over = { canvas: document.createElement("canvas"), looks: "" };
  #due = 0;
  #ratio = 1;
  #font = "sans-serif";
  #leave = new AbortController();
  #observer;

  /** @param {HTMLCanvasElement} canvas whose size is given by a style; it is drawn as large as that */
  constructor(canvas) {
    this.#canvas = canvas;
    this.#context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
    canvas.setAttribute("role", "img");
    this.#observer = new ResizeObserver(() => this.resize());
    this.#observer.observe(canvas);
    const { signal } = this.#leave;
    addEventListener("beforeprint", () => this.#fit(PRINTED), { signal });
    addEventListener("afterprint", () => this.resize(), { signal });
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

  /**
   * Mark a cell, or none.
   * @param {{east: number, north: number} | null} cell from the prey
   */
  mark(cell) {
    this.#marked = cell;
    this.#soon();
  }

  /**
   * Have something drawn over the board, where it is whole, or nothing any more.
   * @param {Above | null} draw
   */
  above(draw) {
    this.#above = draw;
    this.#soon();
  }

  /** The heading of the prey as it is drawn; null where all are side by side. */
  get heading() {
    return this.#sent.tiles ? null : (this.#sent.prey ?? 0);
  }

  /** Draw as sharply as the canvas is large by now. */
  resize() {
    this.#fit(window.devicePixelRatio || 1);
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
    for (const place of this.#places(world).each) {
      const [east, north] = place.at(x, y);
      if (!place.has(east, north)) continue;
      return { east: Math.round(east), north: Math.round(north), heading: place.heading };
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
    const { whole, each } = this.#places(world);
    this.#ground.draw(context, each, sent);
    context.drawImage(this.#drawnOver(whole, each, world), 0, 0);
    drawHunt(context, whole, each, sent);
    for (const place of this.#marked ? each : []) drawMark(context, place, sent, this.#marked);
    if (isOver(sent)) drawWords(context, whole, sent);
    if (!sent.tiles) this.#above?.(context, whole, sent);
    this.drawn += 1;
  }

  /** Draw nothing any more. */
  remove() {
    cancelAnimationFrame(this.#due);
    this.#observer.disconnect();
    this.#leave.abort();
  }

  /** @param {number} ratio */
  #fit(ratio) {
    const { width, height } = this.#canvas.getBoundingClientRect();
    const [wide, high] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (!wide || !high) return;
    this.#ratio = ratio;
    this.#font = getComputedStyle(this.#canvas).fontFamily || this.#font;
    if (this.#canvas.width === wide && this.#canvas.height === high) return;
    this.#canvas.width = wide;
    this.#canvas.height = high;
    // A canvas whose size is set is empty.
    this.draw();
  }

  /**
   * What lies over colours and under a hunt: drawn when it has changed, which is seldom.
   * @param {Place} whole
   * @param {Place[]} each
   * @param {World} world
   */
  #drawnOver(whole, each, world) {
    const [sent, over] = [this.#sent, this.#over];
    const { width, height } = this.#canvas;
    const lines = isOver(sent) ? sent.lines : undefined;
    const { prey, sees, round, tiles, theme } = sent;
    const looks = [world.key, width, height, prey, sees, round, tiles, theme?.border, theme?.field].join();
    if (over.lines === lines && over.looks === looks) return over.canvas;
    Object.assign(over, { lines, looks });
    // A canvas whose size is set is empty.
    Object.assign(over.canvas, { width, height });
    const context = /** @type {CanvasRenderingContext2D} */ (over.canvas.getContext("2d"));
    drawLines(context, whole, lines ?? []);
    for (const place of each) drawBorder(context, place, sent);
    return over.canvas;
  }

  #soon() {
    this.#due ||= requestAnimationFrame(() => this.draw());
  }

  /**
   * Where all lies that is shown, and where each board of it does.
   * @param {World} world
   * @returns {{whole: Place, each: Place[]}}
   */
  #places(world) {
    const { width, height } = this.#canvas;
    const sheet = { width, height, ratio: this.#ratio, font: this.#font };
    if (!this.#sent.tiles) {
      const whole = boardPlace(world, sheet, Boolean(this.#sent.round));
      return { whole, each: [whole] };
    }
    const whole = tilesPlace(world, sheet);
    return { whole, each: tilePlaces(whole) };
  }
}
