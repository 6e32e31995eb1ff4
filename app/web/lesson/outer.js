// @ts-check
// What the page around the frame is told (../lesson.js): whether this browser is in a lesson, which
// controls there are and which keys act; and what that page says.

import { send } from "../player/pipe.js";
import { changed, state, whenChanged } from "./state.js";

/** Questions that are answered on the time bar need it, whatever else there is. */
const ON_BAR = { moment: ["bar"], sketch: ["bar", "curve"] };

const frame = /** @type {HTMLElement | null} */ (window.frameElement);

/** What was told last. */
let before = "";

/** @param {import("../lesson.js").Told} told */
const tell = (told) => {
  const now = JSON.stringify(told);
  if (now === before) return;
  before = now;
  frame?.dispatchEvent(new CustomEvent("pounce-lesson", { bubbles: true, detail: told }));
};

/** Look at no lessons any more. */
export const closeList = () =>
  void frame?.dispatchEvent(new CustomEvent("pounce-lesson-close", { bubbles: true }));

whenChanged(() => {
  const { told } = state;
  if (!told) return;
  const { lesson } = told;
  const where = !lesson ? "none" : told.free ? "free" : "in";
  const ask = lesson?.card.ask;
  const isOpen = ask && !ask.locked;
  const asks = isOpen ? ask.kind : "";
  const needed = ask && ask.kind in ON_BAR ? ON_BAR[/** @type {keyof typeof ON_BAR} */ (ask.kind)] : [];
  tell({
    where,
    asks,
    shows: [...new Set([...(lesson?.show ?? []), ...needed])],
    keys: lesson?.keys ?? [],
  });
});

window.addEventListener("pounce-learn", () => {
  if (state.told?.free) send({ do: "back_to_lesson" });
  changed();
});
