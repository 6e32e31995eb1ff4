// @ts-check
// The page in the frame: the card of a lesson, or the list of lessons.
import "../time/channel.js";
import "./page.js";
