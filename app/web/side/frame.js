// @ts-check
// The page in the frame: runs side by side.
import "../time/channel.js";
import "../time/theme.js";
import "../time/tip.js";
import { on } from "../player/pipe.js";
import "./head.js";
import "./boards.js";
import "./bar.js";
import "./read.js";
import "./choose.js";
import "./keys.js";
import { changed, state } from "./state.js";

for (const kind of /** @type {const} */ (["curves", "moment", "readings", "legend", "cell", "choice"]))
  on(kind, (message) => {
    state[kind] = message;
    changed();
  });
on("race", (race) => {
  state.race = race;
  if (!race.runs.length) state.moment = state.readings = state.curves = state.compare = state.cell = null;
  changed();
});
