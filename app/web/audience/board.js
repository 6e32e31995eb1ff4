// @ts-check
// The board of those who look.

import { Board } from "../player/board.js";

/** Where it is drawn. */
export const canvas = /** @type {HTMLCanvasElement} */ (document.getElementById("board"));
export const board = new Board(canvas);
