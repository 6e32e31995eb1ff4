// @ts-check
// What stands at the top: who leads, and what lets the runs go on, and go faster.

import { attribute, element, write } from "../time/dom.js";
import { send } from "../player/pipe.js";
import { changed, isRacing, state, whenChanged } from "./state.js";

const head = element("header", "head");
head.innerHTML = `
  <p class="standing"></p>
  <p class="said" role="status"></p>
  <div class="tools">
    <span class="group on" role="toolbar" aria-label="Time">
      <button type="button" data-act="play" class="play" title="Pause or play (space)">Play</button>
      <button type="button" data-act="live" class="live" title="Where the runs are now (End)"></button>
      <span class="speed"><select aria-label="Steps a second of each run" title="Steps a second of each run"></select></span>
      <span class="rate"><select aria-label="How fast the past is played" title="How fast the past is played"></select></span>
      <span class="pace"></span>
    </span>
    <span class="group">
      <button type="button" data-act="choose" aria-expanded="false">Choose runs …</button>
      <button type="button" data-act="four" title="The four learners of the thesis's Figure 4.1, in one world, from the same starts">Race the thesis's four</button>
      <button type="button" data-act="present" title="Only this, in large type (P)">Present</button>
      <button type="button" data-act="close" title="Back to the live run (C, or Escape)">Back to one board</button>
    </span>
  </div>`;
document.body.append(head);

const part = (/** @type {string} */ name) => /** @type {HTMLElement} */ (head.querySelector(name));
const speed = /** @type {HTMLSelectElement} */ (part(".speed select"));
const rate = /** @type {HTMLSelectElement} */ (part(".rate select"));
const around = window.parent.document;

/** Have a list offer these, and show one, unless somebody is choosing from it. */
const offer = (
  /** @type {HTMLSelectElement} */ list,
  /** @type {Array<[number, string]>} */ options,
  /** @type {number} */ chosen,
) => {
  const key = JSON.stringify(options);
  if (list.dataset.options !== key) {
    list.dataset.options = key;
    list.replaceChildren(...options.map(([value, text]) => new Option(text, `${value}`)));
  }
  if (document.activeElement !== list) list.value = `${chosen}`;
};

const show = () => {
  const { moment, readings, choosing } = state;
  const isThere = isRacing();
  part('[data-act="choose"]').hidden = !isThere;
  part(".on").hidden = !isThere || choosing;
  part('[data-act="choose"]').setAttribute("aria-expanded", `${choosing}`);
  const present = part('[data-act="present"]');
  write(present, around.documentElement.dataset.present === undefined ? "Present" : "Exit");
  if (!moment || !readings || !isThere) {
    write(part(".standing"), "Runs side by side: which two to four?");
    return;
  }
  const standing = part(".standing");
  if (standing.dataset.html !== readings.standing) {
    standing.dataset.html = readings.standing;
    // Made by the lab, which escapes all names.
    standing.innerHTML = readings.standing;
  }
  const isBack = !moment.live && moment.direction < 0;
  write(part(".play"), moment.playing ? "Pause" : moment.live ? "Play" : "Play the past");
  /** @type {HTMLButtonElement} */ (part(".play")).disabled = moment.live && moment.finished;
  const live = part(".live");
  live.hidden = moment.live;
  write(live, "Back to now");
  part(".rate").hidden = moment.live;
  part(".speed").hidden = !moment.live;
  offer(speed, readings.speeds, readings.speed);
  offer(rate, moment.rates, moment.rate);
  attribute(part(".play"), "data-back", isBack ? "" : null);
  const pace = moment.error ?? (moment.preparing ? "The learners' code is being compiled." : readings.pace);
  write(part(".pace"), moment.live ? pace : "");
};
whenChanged(show);
new MutationObserver(changed).observe(around.documentElement, { attributeFilter: ["data-present"] });

/** What each button does; keys do the same. @type {Record<string, () => unknown>} */
export const ACTS = {
  play: () => send(state.moment?.playing ? { do: "pause" } : { do: "play", direction: 1 }),
  live: () => send({ do: "live" }),
  choose: () => {
    state.choosing = !state.choosing;
    changed();
  },
  four: () => {
    state.choosing = false;
    send({ do: "four" });
    changed();
  },
  present: () => /** @type {HTMLElement | null} */ (around.querySelector("#pounce-stage .present"))?.click(),
  close: () => send({ do: "close" }),
};

head.addEventListener("click", ({ target }) => {
  const node = /** @type {HTMLElement | null} */ (/** @type {Element} */ (target).closest("[data-act]"));
  if (node) ACTS[node.dataset.act ?? ""]?.();
});
speed.addEventListener("change", () => {
  send({ do: "speed", steps_per_s: Number(speed.value) });
  speed.blur();
});
rate.addEventListener("change", () => {
  send({ do: "rate", rate: Number(rate.value) });
  rate.blur();
});

let timer = 0;
const SAID_MS = 7_000;

/**
 * @param {string} text
 * @param {boolean} refused
 */
export const say = (text, refused) => {
  const said = part(".said");
  write(said, text);
  said.classList.toggle("refused", refused);
  clearTimeout(timer);
  timer = setTimeout(() => write(said, ""), SAID_MS);
};
