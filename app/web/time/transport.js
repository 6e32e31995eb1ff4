// @ts-check
// The row above the bar: where one looks, how the past is played, and what a moment is marked with.

import { send } from "../player/pipe.js";
import { attribute, grouped, write } from "./dom.js";
import { goBy } from "./scrub.js";
import { MOST_CHARACTERS, state, whenChanged } from "./state.js";

/** Drawn in a square of 16 by 16, filled. */
const ICONS = {
  begin: "M3 3h2v10H3zM13 3v10L6 8z",
  previous: "M8 3v10L1.5 8zM15 3v10L8.5 8z",
  next: "M8 3v10l6.5-5zM1 3v10l6.5-5z",
  back: "M12 2.5v11L3.5 8z",
  play: "M4 2.5v11L12.5 8z",
  pause: "M3.5 3h3.2v10H3.5zM9.3 3h3.2v10H9.3z",
  // A triangle that comes to a wall.
  stops: "M2 3.5v9L9.5 8zM11 2.5h2.5v11H11z",
  // An A with a flag's pole.
  a: "M7 2h2.2l4 12h-2.2l-.9-3H6l-.9 3H3zM8 4.6 6.6 9.2h2.9z",
  // Around and around.
  loop: "M4 5h7V2.5L15 6l-4 3.500V7H6v2H4zM12 11H5v2.500L1 10l4-3.500V9h5V7h2z",
  mark: "M3 2h1.800v12H3zM5.500 2.500h8L11 5.500l2.500 3h-8z",
  // A hand's open palm would be too small; a snowflake is taken; a pause with an eye above it.
  holds: "M8 2c3 0 5.500 1.700 7 4-1.500 2.300-4 4-7 4s-5.500-1.700-7-4c1.500-2.300 4-4 7-4zm0 2a2 2 0 1 0 0 4 2 2 0 0 0 0-4zM5.500 11.500H7V15H5.500zM9 11.500h1.500V15H9z",
  more: "M2 6.500h3v3H2zM6.500 6.500h3v3h-3zM11 6.500h3v3h-3z",
};

/** @param {string} name */
const icon = (name) =>
  `<svg viewBox="0 0 16 16" aria-hidden="true"><path fill-rule="evenodd" d="${/** @type {Record<string, string>} */ (ICONS)[name]}"/></svg>`;

/**
 * @param {string} act what it does
 * @param {string} label for those who do not see it, and as a hint
 * @param {{key?: string, is?: "switch", rare?: boolean}} [about] `rare` where a narrow bar has it behind "…"
 */
const button = (act, label, { key, is, rare } = {}) =>
  `<button type="button" data-act="${act}" aria-label="${label}" title="${label}${key ? ` (${key})` : ""}"${
    is ? ' aria-pressed="false"' : ""
  }${rare ? ' class="rare"' : ""}>${icon(act)}</button>`;

const row = document.createElement("div");
row.className = "transport";
row.setAttribute("role", "toolbar");
row.setAttribute("aria-label", "Time");
row.innerHTML = `
  <span class="group">${button("begin", "To the beginning", { key: "Home", rare: true })}${button("previous", "To the event before", { key: "[" })}${button("back", "Play backwards")}${button("play", "Play what is looked at")}${button("next", "To the next event", { key: "]" })}</span>
  <span class="where"><button type="button" class="live" data-act="live"><i></i><span class="back">Back to live</span><span class="now">Live</span></button><span class="place"><span></span><span aria-hidden="true"></span></span></span>
  <select class="rate rare" aria-label="How fast the past is played" title="How fast the past is played"></select>
  <span class="group rare">${button("stops", "Stop at events", { is: "switch" })}${button("holds", "The learner waits while I look at the past", { is: "switch" })}</span>
  <span class="group rare">${button("a", "This moment is A", { key: "A" })}${button("loop", "From A to here, again and again", { key: "L", is: "switch" })}${button("mark", "Mark this moment with a line of text", { key: "B" })}</span>
  <button type="button" class="more" data-act="more" aria-expanded="false" aria-label="More" title="More">${icon("more")}</button>`;

/**
 * @template {HTMLElement} T
 * @param {string} selector
 */
const part = (selector) => /** @type {T} */ (row.querySelector(selector));
/** @param {string} act */
const buttonOf = (act) => part(`[data-act="${act}"]`);

const place = part(".place");
const rate = /** @type {HTMLSelectElement} */ (part(".rate"));
const live = part(".live");

// --- What it says ----------------------------------------------------------------------------------

/** @param {number} trials @param {number} steps @param {boolean} isBranch */
const distance = (trials, steps, isBranch) => {
  // At one trial of two lines, which of them made more steps by then says nothing of when it is.
  if (!trials && isBranch) return "level with the live run";
  const [n, unit] = trials ? [trials, "trial"] : [steps, "step"];
  if (n === 0) return "";
  const size = Math.abs(n);
  return `${grouped(size)} ${unit}${size === 1 ? "" : "s"} ${n > 0 ? "behind" : "ahead"}`;
};

/** Where one looks: in a sentence, and in the fewest words. */
const whereabouts = () => {
  const { bar, moment } = state;
  if (!moment || moment.live) return ["", ""];
  const line = bar?.lines.find((each) => each.line === moment.line);
  const isBranch = line !== undefined && !line.live;
  const name = bar?.recorded ? (line?.name ?? "") : isBranch ? line.name : "The past";
  const far = bar?.recorded ? "" : distance(moment.behind_trials, moment.behind_steps, isBranch);
  const parts = [name, `trial ${grouped(moment.trial)}`, far].filter(Boolean);
  const few = isBranch || !name ? parts.slice(0, 2) : parts.slice(1);
  // What happens at this very moment is what one came for, and how far behind it is, is read elsewhere.
  const texts = bar?.happenings.filter(({ step }) => step === moment.step).map(({ text }) => text) ?? [];
  const happens = texts.join(", ");
  if (happens) return [`${parts.join(", ")}: ${happens}`, `${few[isBranch && name ? 1 : 0]}: ${happens}`];
  return [parts.join(", "), few.join(", ").replace(/ trials?( behind| ahead)$/, "$1")];
};

/** @param {HTMLElement} node @param {string} label @param {string} [key] */
const name = (node, label, key) => {
  attribute(node, "aria-label", label);
  attribute(node, "title", key ? `${label} (${key})` : label);
};

let rates = "";

/** For the page around, which has a button that plays, too. @param {boolean} isPlaying */
const tellPage = (isPlaying) => {
  const frame = /** @type {HTMLElement | null} */ (window.frameElement);
  const playing = isPlaying ? "yes" : "no";
  if (!frame || frame.dataset.playing === playing) return;
  frame.dataset.playing = playing;
  frame.dispatchEvent(new CustomEvent("pounce-playing", { bubbles: true }));
};

const show = () => {
  const { moment } = state;
  row.toggleAttribute("data-ready", moment !== null);
  if (!moment) return;
  tellPage(moment.playing);
  const isLive = moment.live && !state.scrub;
  row.toggleAttribute("data-live", isLive);
  name(live, isLive ? "Live: this is what happens now" : "Back to live", "End");
  const [long, short] = whereabouts();
  write(place.children[0], long);
  write(place.children[1], short);
  attribute(place, "title", long);
  for (const [act, direction, label] of /** @type {const} */ ([
    ["play", 1, "Play what is looked at"],
    ["back", -1, "Play backwards"],
  ])) {
    const isOn = moment.playing && moment.direction === direction;
    const node = buttonOf(act);
    if (node.dataset.on !== `${isOn}`) {
      node.dataset.on = `${isOn}`;
      node.innerHTML = icon(isOn ? "pause" : act);
    }
    name(node, isOn ? "Pause" : label, act === "play" ? "space" : undefined);
  }
  const offered = JSON.stringify(moment.rates);
  if (offered !== rates) {
    rates = offered;
    rate.replaceChildren(...moment.rates.map(([value, text]) => new Option(text, `${value}`)));
  }
  // What somebody is choosing from is theirs.
  if (document.activeElement !== rate) rate.value = `${moment.rate}`;
  attribute(buttonOf("stops"), "aria-pressed", `${moment.stops}`);
  attribute(buttonOf("holds"), "aria-pressed", `${moment.holds}`);
  attribute(buttonOf("loop"), "aria-pressed", `${moment.loop !== null}`);
  const a = moment.a ? `A is trial ${grouped(moment.a.trial)}; make it this moment` : "This moment is A";
  name(buttonOf("a"), a, "A");
  buttonOf("a").toggleAttribute("data-set", moment.a !== null);
};

// --- A line of text for a moment -------------------------------------------------------------------

/** Ask for the text of a mark, at the moment that is looked at now, however long that takes. */
const askForMark = () => {
  const { moment } = state;
  if (!moment || document.querySelector(".mark-text")) return;
  const { line, step } = moment;
  const form = document.createElement("form");
  form.className = "mark-text";
  form.innerHTML = `<label><span></span><input type="text" maxlength="${MOST_CHARACTERS}" required autocomplete="off" /></label>
    <button type="submit">Mark</button><button type="button">Cancel</button>`;
  const label = /** @type {HTMLElement} */ (form.querySelector("span"));
  label.textContent = `Mark trial ${grouped(moment.trial)}:`;
  const field = /** @type {HTMLInputElement} */ (form.querySelector("input"));
  const former = document.activeElement;
  const close = () => {
    form.remove();
    if (former instanceof HTMLElement) former.focus();
  };
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    const text = field.value.trim();
    if (text) send({ do: "mark", text, line, step });
    close();
  });
  /** @type {HTMLElement} */ (form.lastElementChild).addEventListener("click", close);
  form.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    event.preventDefault();
    event.stopPropagation();
    close();
  });
  row.after(form);
  field.focus();
};

// --- What it does ----------------------------------------------------------------------------------

/** @param {1 | -1} direction */
const playOrPause = (direction) => {
  const isOn = state.moment?.playing && state.moment.direction === direction;
  send(isOn ? { do: "pause" } : { do: "play", direction });
};

/** What each button does, by its name; keys do the same. @type {Record<string, () => unknown>} */
export const ACTS = {
  begin: () => send({ do: "seek", step: 0 }),
  previous: () => goBy("events", -1),
  next: () => goBy("events", 1),
  back: () => playOrPause(-1),
  play: () => playOrPause(1),
  live: () => send({ do: "live" }),
  stops: () => send({ do: "stops", on: !state.moment?.stops }),
  holds: () => send({ do: "holds", on: !state.moment?.holds }),
  loop: () => send({ do: "loop", on: state.moment?.loop === null }),
  a: () => send({ do: "set_a" }),
  mark: askForMark,
  more: () => {
    const isOpen = row.toggleAttribute("data-all");
    buttonOf("more").setAttribute("aria-expanded", `${isOpen}`);
  },
};

row.addEventListener("click", ({ target }) => {
  const node = /** @type {HTMLElement | null} */ (
    /** @type {Element} */ (target).closest("[data-act]")
  );
  if (node) ACTS[node.dataset.act ?? ""]?.();
});
rate.addEventListener("change", () => {
  send({ do: "rate", rate: Number(rate.value) });
  rate.blur();
});

whenChanged(show);
document.body.prepend(row);
