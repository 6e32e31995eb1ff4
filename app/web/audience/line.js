// @ts-check
// The connection to the lab: what comes is heard, and what is wished or done goes. After a sleep, or
// when the lab was started again, it is made anew, and what was wished last is said again.

import { connectTo, hear } from "../player/pipe.js";

const ADDRESS = new URL("socket", location.href);
ADDRESS.protocol = ADDRESS.protocol.replace("http", "ws");
ADDRESS.search = "";
/** The lab ends a connection with this code when too many look. */
const FULL = 4003;
const FIRST_PAUSE_MS = 500;
const LONGEST_PAUSE_MS = 10_000;
/** A hand that drags wishes no more often than this. */
const NEWEST_MS = 150;

/** @type {WebSocket | undefined} */
let socket;
let pauseMs = FIRST_PAUSE_MS;
let retry = 0;
let timer = 0;
/** What was wished last: it is said again wherever nobody knows of it. */
let newest = "";
/** @type {(text: string) => void} */
let tell = () => {};

const isOpen = () => socket?.readyState === WebSocket.OPEN;

/** What keeps it out, in words; nothing if that is not known. */
const why = async () => {
  try {
    const answer = await fetch("why", { cache: "no-store" });
    return answer.ok ? (await answer.text()).trim() : "";
  } catch {
    return "";
  }
};

/** @param {Blob} packed */
const unpacked = async (packed) => {
  const plain = packed.stream().pipeThrough(new DecompressionStream("deflate"));
  return JSON.parse(await new Response(plain).text());
};

/** Letters are taken in in the order in which they came. */
let order = Promise.resolve();

const connect = () => {
  clearTimeout(retry);
  const made = new WebSocket(ADDRESS);
  socket = made;
  made.addEventListener("open", () => {
    if (newest) made.send(newest);
  });
  made.addEventListener("message", ({ data }) => {
    pauseMs = FIRST_PAUSE_MS;
    tell("");
    const takeIn = async () => {
      const parts = await unpacked(data);
      if (made === socket) for (const part of parts) hear(part);
    };
    // One that cannot be taken in keeps out none of those that follow.
    order = order.then(takeIn).catch((error) => console.error(error));
  });
  made.addEventListener("close", async ({ code }) => {
    if (made !== socket) return;
    retry = setTimeout(connect, pauseMs * (0.7 + 0.6 * Math.random()));
    pauseMs = Math.min(2 * pauseMs, LONGEST_PAUSE_MS);
    if (code === FULL) tell("Too many look already. This page tries again.");
    else {
      const reason = await why();
      if (!isOpen()) tell(reason || "The lab cannot be reached. This page tries again.");
    }
  });
};

const wishNow = () => {
  timer = 0;
  if (isOpen()) socket?.send(newest);
};

connectTo({
  // What is done, and is done once.
  send: (act) => {
    if (!isOpen()) return false;
    socket?.send(JSON.stringify(act));
    return true;
  },
  sendNewest: (wish) => {
    newest = JSON.stringify(wish);
    timer ||= setTimeout(wishNow, NEWEST_MS);
  },
});

/** A device that slept may have a connection that is none any more: nothing tells, so ask at once. */
const wake = () => {
  if (document.visibilityState !== "visible") return;
  if (socket && socket.readyState <= WebSocket.OPEN && performance.now() - leftAt < LONGEST_PAUSE_MS) return;
  pauseMs = FIRST_PAUSE_MS;
  socket?.close();
  connect();
};
let leftAt = performance.now();
document.addEventListener("visibilitychange", () => {
  if (document.visibilityState === "visible") wake();
  else leftAt = performance.now();
});
window.addEventListener("online", () => {
  leftAt = -Infinity;
  wake();
});
window.addEventListener("pageshow", ({ persisted }) => {
  if (persisted) connect();
});

/**
 * Begin, and say how the connection is: nothing where all is well.
 * @param {(text: string) => void} say
 */
export const begin = (say) => {
  tell = say;
  connect();
};
