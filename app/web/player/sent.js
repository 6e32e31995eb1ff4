// @ts-check
// What is sent of boards, as types; how it comes about stands in app/player/boards.py. Places are in
// cells east and north of the prey.

/**
 * @typedef {object} World
 * @property {string} key
 * @property {number} size cells along each side
 * @property {number} rim radius of a round board
 * @property {number} field how far the prey sees
 * @property {number} n_states
 * @property {string} states of each cell, from the south-west on: uint16 in base64
 * @property {{side: number, share: number, height: number, places: [number, number][]}} tiles how all
 *   headings lie side by side: pixels of each, its share of the width of all, their height as a share of
 *   that, and their middles from the middle of all
 *
 * @typedef {object} Line
 * @property {string} colour
 * @property {number} width in pixels, on a board as large as that of the lab
 * @property {number[][]} points x, y, x, y ... of each piece
 * @property {boolean} [arrows] whether each piece is an arrow, from its tail to its head
 *
 * @typedef {object} Hunt
 * @property {number} heading of the prey in the trial
 * @property {boolean} turned whether it is drawn turned
 * @property {[number, number] | null} predator
 * @property {number[]} trail x, y, x, y ...
 * @property {[number, number, Shape, string][]} ends of the last trials, the oldest first
 * @property {{shape: Shape, colour: string}} [ended] how, if it has
 * @property {Word[]} words beside what they are of
 *
 * @typedef {[string, number, number]} Word and its middle
 *
 * @typedef {"circle" | "diamond" | "square"} Shape
 *
 * @typedef {Record<"unknown" | "lines" | "border" | "field" | "prey" | "predator" | "ink", string> & {dark: boolean}} Theme
 *
 * @typedef {object} Sent
 * @property {string} [world] key of the world
 * @property {string} [view] what is looked at, and how
 * @property {"state" | "cell"} [by]
 * @property {string | Uint8Array} [colours] RGB of each state, or of each cell, in base64 or as bytes
 * @property {string | Uint8Array} [dots] the same on dots, where it differs
 * @property {string | Uint8Array} [rising]
 * @property {string | Uint8Array} [falling]
 * @property {number | null} [prey] the heading that is drawn, if any
 * @property {boolean} [sees] whether what it sees is drawn
 * @property {boolean} [round]
 * @property {boolean} [tiles] whether all headings are side by side
 * @property {Theme} [theme]
 * @property {Hunt | null} [hunt]
 * @property {string} [over] the view that lines and labels are of
 * @property {Line[]} [lines]
 * @property {Word[]} [labels]
 */

/**
 * Bytes from base64; what is bytes already stays as it is.
 * @param {string | Uint8Array} text
 */
export const bytesOf = (text) => {
  if (typeof text !== "string") return text;
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = letters.charCodeAt(i);
  return bytes;
};
