// @ts-check
// The class, for whoever presents: how many have answered, and what comes next.

import { send } from "../player/pipe.js";
import { attribute, element, write } from "../time/dom.js";
import { numeral, word } from "./words.js";

/** @typedef {import("./state.js").Vote} Vote */

/** What each button does. */
const ACTS = /** @type {const} */ ([
  ["ask", "askClass", "ask_class"],
  ["again", "voteAgain", "vote_again"],
  ["reveal", "revealClass", "reveal_class"],
  ["end", "endClass", "end_class"],
]);

export const voteNode = element("section", "vote");
const heading = element("h2", "");
const join = element("p", "join");
const counted = element("p", "counted");
counted.setAttribute("role", "status");
const note = element("p", "note");
const acts = element("div", "acts");
voteNode.append(heading, join, counted, note, acts);
const buttons = ACTS.map(([, , say]) => {
  const button = element("button", "");
  button.setAttribute("type", "button");
  button.addEventListener("click", () => send({ do: say }));
  acts.append(button);
  return button;
});

/** @param {Vote | null} vote */
export const showVote = (vote) => {
  voteNode.hidden = !vote;
  if (!vote) return;
  write(heading, word("vote"));
  join.hidden = !vote.code;
  const key = JSON.stringify([vote.code, vote.address, document.documentElement.lang]);
  if (join.dataset.key !== key) {
    join.dataset.key = key;
    const where = vote.address ? [` ${word("at")} `, element("span", "address", vote.address)] : [];
    join.replaceChildren(`${word("join")} `, element("b", "code", vote.code ?? ""), ...where);
  }
  const isCounted = vote.asking || vote.answered > 0;
  write(counted, isCounted ? word("answered", numeral(vote.answered), numeral(vote.seats)) : "");
  counted.hidden = !isCounted;
  write(note, vote.hidden ? word("hidden") : vote.few ? word("few") : "");
  note.hidden = !note.textContent;
  ACTS.forEach(([can, key], at) => {
    buttons[at].hidden = !vote.can.includes(can);
    write(buttons[at], word(key));
    attribute(buttons[at], "data-can", can);
  });
};
