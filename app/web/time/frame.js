// @ts-check
// The page in the frame.
import "./channel.js";
import "./theme.js";
