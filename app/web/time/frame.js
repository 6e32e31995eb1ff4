// @ts-check
// The page in the frame.
import "./channel.js";
import "./bar.js";
import "./theme.js";
