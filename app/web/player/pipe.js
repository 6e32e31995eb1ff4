// @ts-check
// What parts of a page say to whoever answers them, and hear: a server by its websocket, or what the
// page itself has of a run.

/** @typedef {{do: string} & Record<string, any>} Message */

/**
 * Who takes what is sent. `send` says whether it could; `sendNewest` has another message that comes
 * in a moment take the place of this one.
 * @typedef {{send: (message: Message) => boolean, sendNewest?: (message: Message) => void}} Sink
 */

/** @type {Map<string, (message: any) => void>} */
const takers = new Map();
/** @type {Sink | undefined} */
let sink;

/**
 * Have all that is sent from now on taken by one sink.
 * @param {Sink} taker
 */
export const connectTo = (taker) => {
  sink = taker;
};

/**
 * Have messages of a kind taken from now on; one taker for each kind.
 * @param {string} kind
 * @param {(message: any) => void} take
 */
export const on = (kind, take) => void takers.set(kind, take);

/**
 * Hand in a message, as a sink does with what it hears.
 * @param {{kind: string} & Record<string, any>} message
 */
export const hear = (message) => takers.get(message.kind)?.(message);

/**
 * Send a message; whether there is anybody to take it.
 * @param {Message} message
 */
export const send = (message) => sink?.send(message) ?? false;

/**
 * Send a message unless another one comes in a moment, which then takes its place: for what a hand
 * that drags says again and again.
 * @param {Message} message
 */
export const sendNewest = (message) => {
  if (sink?.sendNewest) sink.sendNewest(message);
  else sink?.send(message);
};
