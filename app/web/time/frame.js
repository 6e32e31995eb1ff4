// @ts-check
// The page in the frame.
import "./asks.js";
import "./channel.js";
import "./draw.js";
import "./hand.js";
import "./lesson.js";
import "./theme.js";
import "./tip.js";
import "./told.js";
