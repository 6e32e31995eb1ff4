// @ts-check
// A frame's connection to the lab: JSON both ways, of each kind the newest is shown.
import { connectTo, hear } from "../player/pipe.js";

/** @typedef {import("../player/pipe.js").Message} Message */

const ADDRESS = new URL("socket", location.href);
ADDRESS.protocol = ADDRESS.protocol.replace("http", "ws");
/** The lab ends a connection with this code when the same page was opened once more. */
const REPLACED = 4001;
const FIRST_PAUSE_MS = 500;
const LONGEST_PAUSE_MS = 8_000;
/** What is newest of its kind is sent no more often than a screen is drawn. */
const NEWEST_MS = 16;

/** @type {WebSocket | undefined} */
let socket;
let pauseMs = FIRST_PAUSE_MS;
/** What waits for its turn. @type {Message | undefined} */
let newest;
let timer = 0;

const isOpen = () => socket?.readyState === WebSocket.OPEN;

/** The page around this one says what is wrong where there is no connection (../frame.js). */
const tell = () => {
  document.documentElement.dataset.connection = isOpen() ? "open" : "closed";
  window.frameElement?.dispatchEvent(new CustomEvent("pounce-connection"));
};

const connect = () => {
  const made = new WebSocket(ADDRESS);
  socket = made;
  made.addEventListener("open", () => {
    pauseMs = FIRST_PAUSE_MS;
    tell();
  });
  made.addEventListener("message", ({ data }) => hear(JSON.parse(data)));
  made.addEventListener("close", ({ code }) => {
    newest = undefined;
    tell();
    if (code === REPLACED) return;
    setTimeout(connect, pauseMs);
    pauseMs = Math.min(2 * pauseMs, LONGEST_PAUSE_MS);
  });
};

const sendNewestNow = () => {
  clearTimeout(timer);
  timer = 0;
  if (!newest) return;
  // On a slow way nothing old is to stand before it.
  if (isOpen() && /** @type {WebSocket} */ (socket).bufferedAmount > 0) {
    timer = setTimeout(sendNewestNow, NEWEST_MS);
    return;
  }
  const message = newest;
  newest = undefined;
  if (isOpen()) socket?.send(JSON.stringify(message));
};

/** @param {Message} message */
const send = (message) => {
  if (!isOpen()) return false;
  // What came before it comes first.
  if (newest) socket?.send(JSON.stringify(newest));
  newest = undefined;
  socket?.send(JSON.stringify(message));
  return true;
};

/** @param {Message} message */
const sendNewest = (message) => {
  newest = message;
  if (!timer) timer = setTimeout(sendNewestNow, NEWEST_MS);
};

connectTo({ send, sendNewest });
connect();
