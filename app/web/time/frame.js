// @ts-check
// The page in the frame.
import "./channel.js";
import "./draw.js";
import "./guess.js";
import "./hand.js";
import "./lesson.js";
import "./theme.js";
import "./tip.js";
import "./told.js";
