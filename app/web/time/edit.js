// @ts-check
// Blocks of the schedule in a hand: moved, made longer or shorter, added and deleted, and the probability
// of an exploration. What a hand does is a draft until it lets go; then it is asked for, once.

import { trialAt } from "./axis.js";
import { openChance } from "./chance.js";
import { send } from "../player/pipe.js";
import { grouped } from "./dom.js";
import { say, whenRefused } from "./said.js";
import { shareAt } from "./draw.js";
import { takeBackPresses } from "./scrub.js";
import { changed, state, whenChanged } from "./state.js";

/** @typedef {import("./hand.js").Grip} Grip */
/** @typedef {import("./state.js").Piece} Piece */
/** @typedef {import("./state.js").Draft} Draft */
/** What of a block a hand has. @typedef {"whole" | "first" | "last"} Part */
/** @typedef {{id: string, at: number, trials: number, probability?: number}} Span */

const SNAP_TRIALS = 100;
const FEW_TRIALS = 100;
const MANY_TRIALS = 1_000;
/** As `learners.spec` has it. */
const MOST_TRIALS = 2_000_000;
const NEW = { trials: 2_000, probability: 0.5 };
/** A block that is added by key begins so many trials ahead at least. */
const NEW_AHEAD = 1_000;
/** So long a draft waits to be taken or refused. */
const PATIENCE_MS = 3_000;

// --- What there is ---------------------------------------------------------------------------------

/** @param {string} id */
const pieceOf = (id) =>
  state.bar?.lanes.flatMap((lane) => lane.pieces).find((piece) => piece.id === id);

/** @param {Element | null} element a block, or a number of one */
const pieceAt = (element) =>
  element instanceof HTMLElement ? pieceOf(element.dataset.id ?? "") : undefined;

/** @param {Piece} piece */
const blockOf = ({ id }) =>
  /** @type {HTMLElement | null} */ (document.querySelector(`.piece[data-id="${CSS.escape(id)}"]`));

/** @param {Piece} piece @returns {Span} */
const spanOf = ({ id, first, until, probability }) => ({
  id,
  at: first,
  trials: (until ?? first) - first,
  probability: probability ?? undefined,
});

/**
 * A block as it is seen: as a hand has it, if one has.
 * @param {Piece} piece
 * @returns {Span}
 */
const seen = (piece) => ({
  ...spanOf(piece),
  ...(state.draft?.id === piece.id ? state.draft : {}),
});

/** The first trial that is not past at the moment that is looked at. */
const firstAhead = () => (state.moment?.trial ?? 0) + 1;

/** @param {Piece} piece */
const isFree = (piece) => piece.editable && piece.first >= firstAhead();

/** @param {Piece} piece */
const whyLocked = (piece) => {
  if (state.bar?.recorded) return "This is a recording: nothing of it can be changed.";
  if (piece.kind === "frozen" || piece.kind === "taught" || piece.first >= firstAhead())
    return "What was done by hand is not in the plan. Undo takes it back.";
  if (piece.first === 0) return "This was there from the beginning, and is locked.";
  return (
    `What began at trial ${grouped(piece.first)} is past, and locked. Go back to before it to change it` +
    " there: that makes a branch."
  );
};

// --- What a hand does with a block: pure ---------------------------------------------------------

/**
 * @param {number} trial
 * @param {boolean} isExact
 */
const snapped = (trial, isExact) =>
  isExact ? Math.round(trial) : Math.round(trial / SNAP_TRIALS) * SNAP_TRIALS;

/** @param {number} x @param {number} low @param {number} high */
const within = (x, low, high) => Math.min(Math.max(x, low), Math.max(low, high));

/**
 * A block whose part was moved by some trials.
 * @param {Span} span
 * @param {Part} part
 * @param {number} by
 * @param {boolean} isExact whether it goes to any trial, and not to every hundredth
 * @param {{earliest: number, shortest: number}} bounds
 * @returns {Draft}
 */
const moved = (span, part, by, isExact, { earliest, shortest }) => {
  const { id, at, trials } = span;
  const until = at + trials;
  if (part === "whole")
    return { id, at: within(snapped(at + by, isExact), earliest, MOST_TRIALS), trials };
  if (part === "last")
    return { id, at, trials: within(snapped(until + by, isExact) - at, shortest, MOST_TRIALS) };
  const first = within(snapped(at + by, isExact), earliest, until - shortest);
  return { id, at: first, trials: until - first };
};

/** @param {Piece} piece */
const boundsOf = (piece) => {
  const lane = state.bar?.lanes.find(({ pieces }) => pieces.includes(piece));
  // A skill is not explored before it joins.
  const joins = lane?.pieces.find((each) => each.kind === "join" && isFree(each))?.first ?? 0;
  return piece.kind === "join"
    ? { earliest: firstAhead(), shortest: 0 }
    : { earliest: Math.max(firstAhead(), joins), shortest: 1 };
};

// --- Drafts, and what becomes of them ------------------------------------------------------------

/**
 * What has been asked for and is not answered: of which block, on which line, and what the plan may
 * have until it is, from how the block was at first to what it became before.
 * @type {{id: string, line: number | undefined, passed: Span[]} | null}
 */
let asked = null;
/**
 * The same of a block that a hand goes on with, and last what it is to become by what was asked.
 * @type {{id: string, spans: Span[]} | null}
 */
let awaited = null;
let timer = 0;

/** @param {Draft | null} draft */
const draftIs = (draft) => {
  // What a hand goes on with is not what it has asked for.
  clearTimeout(timer);
  asked = null;
  state.draft = draft;
  changed();
};

/** Show what is in the plan again. */
const forgetDraft = () => {
  awaited = null;
  draftIs(null);
};

/**
 * Leave the draft as it is until the plan has it.
 * @param {string} id
 * @param {Span[]} spans
 */
const wait = (id, spans) => {
  awaited = { id, spans };
  asked = { id, line: state.bar?.line, passed: spans.slice(0, -1) };
  clearTimeout(timer);
  timer = setTimeout(forgetDraft, PATIENCE_MS);
};

/** @param {Span} one @param {Span} other */
const isSame = (one, other) =>
  one.at === other.at && one.trials === other.trials && one.probability === other.probability;

/**
 * Ask for what a block has become by hand.
 * @param {Piece} piece
 */
const ask = (piece) => {
  const now = seen(piece);
  const { id } = piece;
  // What was asked before may not be in the plan yet.
  const before = awaited?.id === id ? awaited.spans : [spanOf(piece)];
  const former = before[before.length - 1];
  if (isSame(former, now)) return before.length > 1 ? wait(id, before) : forgetDraft();
  /** @type {{do: string} & Draft} */
  const message = { do: "edit", id };
  if (now.at !== former.at) message.at = now.at;
  if (now.trials !== former.trials) message.trials = now.trials;
  if (now.probability !== former.probability) message.probability = now.probability;
  if (!send(message)) {
    say("There is no connection to the lab: nothing was changed.");
    return forgetDraft();
  }
  wait(id, [...before, now]);
};

whenRefused(() => {
  if (asked) forgetDraft();
});
// A draft stays until the plan is another one, or that of another line: whatever it is then is what was
// taken.
whenChanged(() => {
  if (!asked || state.held) return;
  const piece = pieceOf(asked.id);
  const isSameLine = state.bar?.line === asked.line;
  const is = piece && spanOf(piece);
  if (!isSameLine || !is || !asked.passed.some((span) => isSame(span, is))) forgetDraft();
});

// --- By pointer ------------------------------------------------------------------------------------

/** From so far away an end of a block is taken. A finger is broader than a pointer. */
const NEAR_PX = { mouse: 5, pen: 5, touch: 11 };

/**
 * What of a lane is taken at a place. By what lies on top nothing could be told: when a skill joins is
 * a line, its freeze often no broader, and the exploration that begins with it lies below both.
 * @param {Element} lane
 * @param {number} x
 * @param {number} near
 * @returns {{piece: Piece, part: Part} | null}
 */
const taken = (lane, x, near) => {
  const blocks = [...lane.querySelectorAll(".piece[data-editable]")].flatMap((block) => {
    const piece = pieceAt(block);
    const { left, right } = block.getBoundingClientRect();
    return piece ? [{ piece, left, right, isFocused: block === document.activeElement }] : [];
  });
  const joins = blocks.filter(({ piece }) => piece.kind === "join");
  for (const { piece, left, right, isFocused } of joins) {
    // What has the focus has its end beside it, however short its freeze is.
    const end = isFocused ? Math.max(right, left + 2 * near) : right;
    if ((isFocused || right > left + 4 * near) && Math.abs(x - end) <= near)
      return { piece, part: "last" };
    if (Math.abs(x - left) <= near) return { piece, part: "whole" };
  }
  const explorations = blocks
    .filter(({ piece, left, right }) => piece.kind === "forced" && x >= left - near && x <= right + near)
    .sort((one, other) => one.right - one.left - (other.right - other.left));
  for (const { piece, left, right } of explorations) {
    const grip = Math.min(near, (right - left) / 3);
    if (x >= right - grip) return { piece, part: "last" };
    // One that begins when its skill joins begins with that.
    const isBound = joins.some((join) => join.piece.first === piece.first);
    return { piece, part: x <= left + grip && !isBound ? "first" : "whole" };
  }
  const within = joins.find(({ left, right }) => x >= left && x <= right);
  return within ? { piece: within.piece, part: "whole" } : null;
};

/**
 * @param {PointerEvent} event
 * @returns {{piece: Piece, part: Part, chance: Piece | null} | null} `chance`: whose number is under it
 */
const takenBy = ({ target, clientX, pointerType }) => {
  const element = /** @type {Element} */ (target).closest(".piece, .chance[data-id]");
  const piece = pieceAt(element);
  const lane = element?.closest(".lane");
  if (!piece || !lane) return null;
  const near = pointerType === "touch" ? NEAR_PX.touch : NEAR_PX.mouse;
  const found = taken(lane, clientX, near) ?? { piece, part: /** @type {Part} */ ("whole") };
  // The end of a freeze may lie under a number: a drag has that end, and a tap the number.
  return { ...found, chance: element?.matches(".chance") ? piece : null };
};

/**
 * @param {PointerEvent} event
 * @returns {Grip | null}
 */
export const blockGrip = (event) => {
  const found = takenBy(event);
  if (!found) return null;
  const { piece, part, chance } = found;
  blockOf(piece)?.focus({ preventScroll: true });
  const nothing = () => {};
  if (!isFree(piece)) {
    const why = () => say(whyLocked(piece));
    return { isAtOnce: false, move: why, release: nothing, tap: why, giveUp: nothing };
  }
  const span = seen(piece);
  const axis = state.bar?.axis;
  const from = axis ? trialAt(axis, shareAt(event)) : 0;
  return {
    isAtOnce: false,
    move: (at) => {
      if (!axis) return;
      const by = trialAt(axis, shareAt(at)) - from;
      draftIs({ ...span, ...moved(span, part, by, at.altKey || at.shiftKey, boundsOf(piece)) });
    },
    release: () => ask(piece),
    tap: () => {
      if (chance) editChance(chance);
      else send({ do: "choose", id: piece.id });
    },
    giveUp: forgetDraft,
  };
};

// The pointer says what it would take.
document.body.addEventListener("pointermove", (event) => {
  if (event.buttons) return;
  const found = takenBy(event);
  const what = found && isFree(found.piece) ? (found.part === "whole" ? "block" : "end") : "";
  if (document.body.dataset.over !== what) document.body.dataset.over = what;
});

/** @param {Piece} piece */
const editChance = (piece) => {
  if (piece.probability === null)
    return say("A skill that joins has no probability; its explorations have.");
  const shown = document.querySelector(`.chance[data-id="${CSS.escape(piece.id)}"]`);
  const place = shown ?? blockOf(piece);
  if (!place) return;
  openChance(place, `Probability: ${piece.what}`, seen(piece).probability ?? 0, {
    show: (chance) => draftIs({ ...seen(piece), probability: chance }),
    take: () => ask(piece),
    giveUp: forgetDraft,
    close: () => blockOf(piece)?.focus({ preventScroll: true }),
  });
};

/**
 * Explore a skill from a trial on.
 * @param {string} skill
 * @param {number} at
 */
const add = (skill, at) => {
  if (!skill) return;
  if (at < firstAhead())
    return say(
      `Trial ${grouped(at)} is past. Go there first: what is added there makes a branch.`,
    );
  if (!send({ do: "add", skill, at, ...NEW }))
    say("There is no connection to the lab: nothing was added.");
};

document.body.addEventListener("dblclick", (event) => {
  // The first press may have taken the pointer for all of the page.
  const target = document.elementFromPoint(event.clientX, event.clientY);
  const lane = /** @type {HTMLElement | null} */ (target?.closest(".lane"));
  if (!lane || !state.bar || !target?.closest(".plot") || target.closest(".piece, .playhead")) return;
  const at = snapped(trialAt(state.bar.axis, shareAt(event)), event.altKey || event.shiftKey);
  takeBackPresses();
  add(lane.dataset.skill ?? "", at);
});

/**
 * Where an exploration that is added without saying where begins: soon, and not before the skill joins
 * or where another one is.
 * @param {string} skill
 */
const soonest = (skill) => {
  const soon = Math.ceil((firstAhead() + NEW_AHEAD) / SNAP_TRIALS) * SNAP_TRIALS;
  const mine = state.bar?.lanes.find((lane) => lane.skill === skill)?.pieces ?? [];
  const joins = mine.find((piece) => piece.kind === "join" && isFree(piece));
  const ends = mine.filter(({ kind }) => kind === "forced").map(({ until }) => until ?? 0);
  return Math.max(soon, joins?.first ?? 0, ...ends);
};

document.body.addEventListener("click", ({ target }) => {
  const button = /** @type {Element} */ (target).closest(".lane .add");
  const lane = /** @type {HTMLElement | null | undefined} */ (button?.closest(".lane"));
  const skill = lane?.dataset.skill;
  if (skill) add(skill, soonest(skill));
});

// --- By key ----------------------------------------------------------------------------------------

/** @type {Record<string, number>} */
const ARROWS = { ArrowLeft: -1, ArrowRight: 1 };
/** The block that arrows are moving, until they are let go. @type {Piece | null} */
let pushed = null;

/**
 * @param {Piece} piece
 * @param {KeyboardEvent} event
 */
const push = (piece, { key, shiftKey, altKey }) => {
  if (!isFree(piece)) return say(whyLocked(piece));
  const by = ARROWS[key] * (shiftKey ? MANY_TRIALS : FEW_TRIALS);
  const span = seen(piece);
  pushed = piece;
  draftIs({ ...span, ...moved(span, altKey ? "last" : "whole", by, true, boundsOf(piece)) });
};

const endPush = () => {
  if (!pushed) return;
  const piece = pushed;
  pushed = null;
  ask(pieceOf(piece.id) ?? piece);
};

/** @param {Piece} piece */
const remove = (piece) => {
  if (!isFree(piece)) return say(whyLocked(piece));
  if (piece.kind === "join") return say("When a skill joins can be moved, not deleted.");
  forgetDraft();
  const elements = /** @type {HTMLElement[]} */ ([...document.querySelectorAll(".piece")]);
  const place = elements.findIndex(({ dataset }) => dataset.id === piece.id);
  if (!send({ do: "delete", id: piece.id }))
    return say("There is no connection to the lab: nothing was deleted.");
  // Who goes by keys is where the next thing is.
  (elements[place + 1] ?? elements[place - 1])?.focus({ preventScroll: true });
};

document.body.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey) return;
  const piece = pieceAt(/** @type {Element} */ (event.target).closest(".piece"));
  if (!piece) return;
  const { key } = event;
  if (key in ARROWS) push(piece, event);
  else if (key === "Delete" || key === "Backspace") remove(piece);
  else if (key === "Enter") {
    send({ do: "choose", id: piece.id });
    if (isFree(piece)) editChance(piece);
    else say(whyLocked(piece));
  } else if (key === "Escape" && state.draft) {
    pushed = null;
    forgetDraft();
  } else return;
  event.preventDefault();
  event.stopPropagation();
});
document.body.addEventListener("keyup", ({ key }) => {
  if (key in ARROWS) endPush();
});
document.body.addEventListener("focusout", endPush);
