// @ts-check
// The lanes of the schedule, and the bands that its blocks are across the curve.

import { shareOfTrial, trialAt } from "./axis.js";
import { attribute, element, grouped, keep, percent, reach, write } from "./dom.js";

/**
 * @typedef {import("./state.js").Bar} Bar
 * @typedef {import("./state.js").Draft} Draft
 * @typedef {import("./state.js").Label} Label
 * @typedef {import("./state.js").Lane} Lane
 * @typedef {import("./state.js").Piece} Piece
 * @typedef {import("./state.js").Place} Place
 * @typedef {{first: number, until: number | null, probability: number | null}} Span
 */

/** With more lanes than this each is lower. */
const MANY_LANES = 5;
const LOCKED = "It has begun, so it is locked. Look at an earlier moment to change it there.";
const BY_HAND = "What was begun by hand is not in the plan. Undo takes it back.";
const CHANGED = "Drag it, or move it with the arrow keys. Enter edits it.";
/** Of more blocks than this the keyboard stops only at those that it can change. */
const MOST_STOPS = 20;
/** Room that a number takes beside its block, in sizes of the type. */
const NUMBER = 3.7;

/** What is said of a join, and what it is called where one looks at a moment before it. */
const JOINED = "joined at ";
const JOINS = "joins at ";

/** The blocks that are drawn, with what each is of. @type {Array<[HTMLElement, Piece]>} */
let drawn = [];
/** What is said of joins, with the trials in which these were. @type {Array<[HTMLElement, number]>} */
let joins = [];

/**
 * What a hand makes of blocks, by their keys: of the one that it has, and of explorations that begin
 * when a skill joins, which go with that.
 * @param {Bar} bar
 * @param {Draft | null} draft
 * @returns {Map<string, Span>}
 */
const drafted = (bar, draft) => {
  /** @type {Map<string, Span>} */
  const spans = new Map();
  if (!draft) return spans;
  for (const { pieces } of bar.lanes) {
    const held = pieces.find(({ id, editable }) => editable && id === draft.id);
    if (!held) continue;
    const first = draft.at ?? held.first;
    const trials = draft.trials ?? (held.until ?? held.first) - held.first;
    const probability = draft.probability ?? held.probability;
    spans.set(held.key, { first, until: first + trials, probability });
    for (const piece of pieces)
      if (isBound(piece, pieces) && held.kind === "join") {
        const until = piece.until === null ? null : piece.until + first - held.first;
        spans.set(piece.key, { first, until, probability: piece.probability });
      }
  }
  return spans;
};

/**
 * Whether an exploration begins when its skill joins.
 * @param {Piece} piece
 * @param {Piece[]} pieces of its lane
 */
const isBound = (piece, pieces) =>
  piece.kind === "forced" && pieces.some(({ kind, first }) => kind === "join" && first === piece.first);

/**
 * The trial in which a block ends, or that which runs if nobody has ended it.
 * @param {{until: number | null}} block
 * @param {Place} now
 */
const end = ({ until }, now) => until ?? now.trial;

/**
 * @param {HTMLElement} parent
 * @param {Bar} bar
 * @param {Draft | null} draft
 */
export const drawLanes = (parent, bar, draft) => {
  const spans = drafted(bar, draft);
  drawn = [];
  joins = [];
  parent.classList.toggle("low", bar.lanes.length > MANY_LANES);
  keep(parent, bar.lanes, ({ name }) => name, makeLane, (row, lane) => {
    const [gutter, plot] = row.children;
    write(gutter.children[0], lane.name);
    attribute(gutter, "title", lane.name);
    attribute(row, "data-skill", lane.skill);
    drawLane(plot, bar, lane, draft, spans);
  });
};

/** @param {Lane} lane */
const makeLane = ({ name, skill }) => {
  const row = element("div", "row lane");
  const gutter = element("div", "gutter");
  gutter.append(element("span", "name"));
  if (skill) {
    // A button for those who have no mouse to click twice with (edit.js).
    const add = element("button", "add", "+");
    add.title = `Add an exploration of ${name}`;
    add.setAttribute("aria-label", add.title);
    gutter.append(add);
  }
  const plot = element("div", "plot");
  for (const part of ["presence", "blocks", "labels"]) plot.append(element("div", part));
  row.append(gutter, plot);
  return row;
};

/**
 * @param {Element} plot
 * @param {Bar} bar
 * @param {Lane} lane
 * @param {Draft | null} draft
 * @param {Map<string, Span>} spans
 */
const drawLane = (plot, bar, lane, draft, spans) => {
  const { axis, end: now } = bar;
  const at = (/** @type {number} */ trial) => shareOfTrial(axis, trial);
  const [presence, blocks, labels] = plot.children;
  presence.replaceChildren(
    ...lane.presence.map(({ first, until, ahead }) => {
      const there = element("i", ahead ? "there ahead" : "there");
      reach(there, at(first), until === null ? (ahead ? 1 : at(now.trial)) : at(until));
      return there;
    }),
  );
  /** @type {Array<Piece & {was?: boolean}>} */
  const all = [
    ...lane.pieces.filter(({ key }) => spans.has(key)).map((piece) => ({ ...piece, was: true })),
    ...lane.pieces,
  ];
  keep(blocks, all, (piece) => (piece.was ? `was ${piece.key}` : piece.key), makePiece, (block, piece, index) => {
    block.style.zIndex = `${index}`;
    const held = piece.was ? undefined : spans.get(piece.key);
    drawPiece(block, bar, piece, held, isBound(piece, lane.pieces));
  });
  const shown = lane.labels.filter(({ of }) => !of.some((key) => spans.has(key)));
  const held = lane.pieces.find(({ id, editable }) => editable && id === draft?.id);
  const span = held && spans.get(held.key);
  const told = held && span ? numbersOf(held, span, at, roomIn(plot)) : [];
  const ids = new Map(lane.pieces.filter(({ editable }) => editable).map(({ key, id }) => [key, id]));
  labels.replaceChildren(...shown.map((label) => drawnLabel(label, ids)), ...told);
  shown.forEach(({ before, of }, place) => {
    const joined = before === JOINED && lane.pieces.find(({ key }) => key === of[0]);
    const said = /** @type {HTMLElement} */ (labels.children[place].firstElementChild);
    if (joined) joins.push([said, joined.first]);
  });
};

const makePiece = () => {
  const block = element("div", "piece");
  block.append(element("i", "done"));
  return block;
};

/**
 * @param {HTMLElement} block
 * @param {Bar} bar
 * @param {Piece & {was?: boolean}} piece
 * @param {Span | undefined} held what a hand makes of it
 * @param {boolean} bound
 */
const drawPiece = (block, bar, piece, held, bound) => {
  const { first, until, kind, half } = held ? { ...piece, ...held } : piece;
  const at = (/** @type {number} */ trial) => shareOfTrial(bar.axis, trial);
  const ends = until === null ? bar.end.trial : until;
  reach(block, at(first), at(ends));
  const flags = {
    idle: piece.idle,
    hand: piece.hand,
    chosen: piece.chosen,
    held: held !== undefined,
    was: piece.was ?? false,
  };
  const names = Object.entries(flags).flatMap(([name, is]) => (is ? [name] : []));
  block.className = ["piece", kind, half, ...names].join(" ");
  if (piece.was) return void attribute(block, "aria-hidden", "true");
  block.dataset.id = piece.id;
  // What it says of itself is to be found anew.
  delete block.dataset.free;
  drawn.push([block, piece]);
  edges(block, piece, bound);
};

/**
 * What the ends of a block are taken by.
 * @param {HTMLElement} block
 * @param {Piece} piece
 * @param {boolean} bound
 */
const edges = (block, piece, bound) => {
  const isRange = piece.editable && piece.until !== null && (piece.kind === "forced" || piece.until > piece.first);
  const sides = !isRange ? [] : bound || piece.kind === "join" ? ["last"] : ["first", "last"];
  keep(
    block,
    sides,
    (side) => side,
    (side) => element("b", `edge ${side}`),
    () => {},
  );
};

/** @param {Element} plot */
const roomIn = (plot) =>
  (NUMBER * parseFloat(getComputedStyle(plot).fontSize)) / (plot.clientWidth || 1);

/**
 * The numbers of a block while a hand has it.
 * @param {Piece} piece
 * @param {Span} held
 * @param {(trial: number) => number} at
 * @param {number} room that a number takes, as a share of the axis
 */
const numbersOf = (piece, { first, until, probability }, at, room) => {
  const last = until ?? first;
  const number = (/** @type {string} */ text, /** @type {string} */ side, /** @type {number} */ place) => {
    const shown = element("span", `number ${side}`, text);
    shown.style.left = percent(place);
    return shown;
  };
  const from = at(first);
  const numbers = [number(grouped(first), from < room ? "after" : "before", from)];
  // When a skill joins, the end is that of the freeze, which is told where it becomes another.
  const isRange = piece.kind !== "join" || last - first !== (piece.until ?? 0) - piece.first;
  if (last > first && isRange) {
    const isAtEnd = at(last) > 1 - room;
    // Of two that would lie on one another the first is told.
    const isFree = isAtEnd || from < room ? at(last) - from > room : true;
    if (isFree) numbers.push(number(grouped(last), isAtEnd ? "before" : "after", at(last)));
  }
  if (probability !== null && at(last) - from > room)
    numbers.push(number(`${Math.round(100 * probability)}%`, "within", (from + at(last)) / 2));
  return numbers;
};

/**
 * What is said in a lane; a probability can be edited where it stands.
 * @param {Label} label
 * @param {Map<string, string>} ids by which blocks can be edited, by their keys
 */
const drawnLabel = ({ of, before, text, after, at, side, room }, ids) => {
  const label = element("span", `label ${side}`);
  if (side === "before") label.style.right = percent(1 - at);
  else label.style.left = percent(at);
  label.style.maxWidth = percent(room);
  if (before) label.append(element("span", "more", before));
  // Of several blocks there are as many probabilities.
  const parts = text.split(", ");
  if (parts.length === of.length && text.endsWith("%"))
    parts.forEach((chance, index) => {
      const shown = element("span", "chance", chance);
      const id = ids.get(of[index]);
      if (id) shown.dataset.id = id;
      label.append(...(index ? [", "] : []), shown);
    });
  else label.append(text);
  if (after) label.append(element("span", "more", after));
  return label;
};

/**
 * What of the blocks depends on where one looks: which have begun there, and so are locked; and how
 * far those have come that run now. Nothing is made anew, and only what differs is touched.
 * @param {Bar} bar
 * @param {Place} now how far the line is known
 * @param {Place} seen the moment that is looked at
 */
export const markLanes = (bar, now, seen) => {
  const at = (/** @type {number} */ trial) => shareOfTrial(bar.axis, trial);
  const last = trialAt(bar.axis, 1);
  for (const [block, piece] of drawn) {
    if (!block.classList.contains("held")) markCome(block, piece, at, now);
    markFree(block, piece, seen, last, bar.recorded);
  }
  for (const [said, first] of joins) write(said, first > seen.trial ? JOINS : JOINED);
};

/**
 * How far it has come.
 * @param {HTMLElement} block
 * @param {Piece} piece
 * @param {(trial: number) => number} at
 * @param {Place} now
 */
const markCome = (block, piece, at, now) => {
  const ends = end(piece, now);
  if (piece.until === null) reach(block, at(piece.first), at(ends));
  const come = piece.idle ? piece.first : Math.min(Math.max(now.trial, piece.first), ends);
  const share = (at(come) - at(piece.first)) / (at(ends) - at(piece.first) || 1);
  const width = percent(Math.min(share, 1));
  const done = /** @type {HTMLElement} */ (block.firstElementChild);
  if (done.style.width !== width) done.style.width = width;
  const isToCome = piece.idle || now.trial < piece.first;
  block.classList.toggle("ahead", come < ends || (ends === piece.first && isToCome));
};

/**
 * Whether it can be changed from where one looks.
 * @param {HTMLElement} block
 * @param {Piece} piece
 * @param {Place} seen
 * @param {number} last trial of the axis
 * @param {boolean} isFixed whether nothing can be changed from anywhere
 */
const markFree = (block, piece, seen, last, isFixed) => {
  const isFree = piece.editable && piece.first > seen.trial;
  const isOver = piece.first <= seen.trial;
  const state = isFree ? "free" : isOver ? "over" : "other";
  if (block.dataset.free === state) return;
  block.dataset.free = state;
  block.toggleAttribute("data-editable", isFree);
  block.classList.toggle("locked", !isFree);
  const why = isFree ? CHANGED : ["taught", "frozen"].includes(piece.kind) || !isOver ? BY_HAND : LOCKED;
  const { first, hint } = piece;
  attribute(block, "title", isFixed ? hint : `${hint}\n${why}`);
  attribute(block, "aria-label", hint);
  attribute(block, "tabindex", isFree || drawn.length <= MOST_STOPS ? "0" : "-1");
  attribute(block, "role", isFree ? "slider" : "img");
  attribute(block, "aria-disabled", isFree ? null : "true");
  attribute(block, "aria-valuenow", isFree ? `${first}` : null);
  attribute(block, "aria-valuemin", isFree ? `${seen.trial + 1}` : null);
  attribute(block, "aria-valuemax", isFree ? `${Math.max(first, last)}` : null);
  attribute(block, "aria-valuetext", isFree ? `trial ${grouped(first)}` : null);
};

/**
 * Where exploration is forced or something frozen, across curve and lanes.
 * @param {HTMLElement} over
 * @param {Bar} bar
 * @param {Draft | null} draft
 */
export const drawBands = (over, bar, draft) => {
  const spans = drafted(bar, draft);
  over.replaceChildren(
    ...bar.bands.flatMap((band) => {
      const held = spans.get(band.key) ?? band;
      const ends = end(held, bar.end);
      const middle = Math.min(Math.max(bar.end.trial, held.first), ends);
      return [
        { first: held.first, until: middle, kind: band.kind },
        { first: middle, until: ends, kind: `${band.kind} ahead` },
      ].filter(({ first, until }) => until > first);
    }).map(({ first, until, kind }) => {
      const band = element("i", `band ${kind}`);
      reach(band, shareOfTrial(bar.axis, first), shareOfTrial(bar.axis, until));
      return band;
    }),
  );
};
