// @ts-check
// Says in words that the page has no connection to the lab, and why.

const PATIENCE_MS = 4_000;
/** Attempts after which a websocket that fails, while the lab answers, is no accident. */
const ATTEMPTS = 3;
const LOST =
  "The lab does not answer. It was ended, or the network is gone; this page reconnects by itself.";
const NO_WEBSOCKET =
  "The lab answers, but its websocket does not get through: a proxy between this page and the lab " +
  "must speak HTTP/1.1 and pass on the headers Upgrade and Connection.";

const notice = document.createElement("div");
notice.id = "lab-connection";
notice.setAttribute("role", "status");
document.body.append(notice);

let failures = 0;
let isAsking = false;

/** What the lab says of a websocket from here; nothing if it would let one in. */
const refusal = async () => {
  try {
    const answer = await fetch(`why?origin=${encodeURIComponent(location.origin)}`, {
      cache: "no-store",
      signal: AbortSignal.timeout(PATIENCE_MS),
    });
    if (answer.status === 204) return "";
    const isOurs = answer.headers.get("Content-Type")?.startsWith("text/plain");
    return isOurs ? (await answer.text()).trim() : LOST;
  } catch {
    return LOST;
  }
};

const explain = async () => {
  failures += 1;
  if (isAsking) return;
  isAsking = true;
  const reason = await refusal();
  isAsking = false;
  // It may have come back in the meantime.
  if (failures === 0) return;
  notice.textContent = reason || (failures < ATTEMPTS ? "" : NO_WEBSOCKET);
};

const isConnected = () => document.documentElement.dataset.connection === "connected";

document.addEventListener("lab:connection", () => {
  if (!isConnected()) return void explain();
  failures = 0;
  notice.textContent = "";
});

// Before this script came, or without any attempt so far.
if (document.documentElement.dataset.connection === "closed") void explain();
setTimeout(() => {
  if (document.documentElement.dataset.connection === undefined) void explain();
}, PATIENCE_MS);
