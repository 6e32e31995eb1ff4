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
 * @property {{side: number, share: number, places: [number, number][]}} tiles
 *
 * @typedef {object} Line
 * @property {string} colour
 * @property {number} width in pixels, on a board as large as that of the lab
 * @property {number[][]} points x, y, x, y ... of each piece
 *
 * @typedef {object} Hunt
 * @property {number} heading of the prey in the trial
 * @property {boolean} turned whether it is drawn turned
 * @property {[number, number] | null} predator
 * @property {number[]} trail x, y, x, y ...
 * @property {[number, number, Shape, string][]} ends of the last trials, the oldest first
 * @property {{shape: Shape, colour: string, word: [string, number, number]}} [ended]
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
 * @property {[string, number, number][]} [labels]
 */

/**
 * Bytes from base64; what is bytes already stays as it is.
 * @param {string | Uint8Array} text
 */
export const bytesOf = (text) =>
  typeof text === "string" ? Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)) : text;
