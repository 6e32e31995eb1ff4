// @ts-check
// Sharing: copies a link when there is a new one, and asks for what came in a link to this page.

import { whenChanged } from "./changes.js";

const TICKET = "shared";
const COPIED = "Copied: ";
const NOT_COPIED = "Copy its address: ";

/** What was copied: a link that is shown again is not. @type {Map<string, string>} */
const done = new Map();

/**
 * Where the page is not from a secure place the browser has no other way.
 * @param {string} text
 */
const copyByHand = (text) => {
  const field = document.createElement("textarea");
  field.value = text;
  field.style.position = "fixed";
  field.style.opacity = "0";
  document.body.append(field);
  field.select();
  const isCopied = document.execCommand("copy");
  field.remove();
  return isCopied;
};

/** Whether the page was reached at an address that is another machine for others. */
const isOnlyHere = /^(localhost|127\..*|\[::1\])$/.test(location.hostname);

/** @param {string} text */
const copy = async (text) => {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return copyByHand(text);
  }
};

const copyLinks = () => {
  for (const made of document.querySelectorAll("[data-copy-link]")) {
    const link = made.querySelector("a");
    const status = made.querySelector("[role=status]");
    for (const text of /** @type {NodeListOf<HTMLElement>} */ (made.querySelectorAll("[data-where]")))
      text.hidden = (text.dataset.where === "here") !== isOnlyHere;
    if (!link || !status) continue;
    const key = `${made.getAttribute("data-copy-link")} ${link.href}`;
    const said = done.get(key);
    if (said !== undefined) {
      if (status.textContent !== said) status.textContent = said;
      continue;
    }
    done.set(key, "");
    void copy(link.href).then((isCopied) => {
      done.set(key, isCopied ? COPIED : NOT_COPIED);
      copyLinks();
    });
  }
};

/** What came in the address of this page, which is good for once. */
let ticket = new URLSearchParams(location.search).get(TICKET) ?? "";

const ask = () => {
  const address = document.querySelector("[data-shared-call]")?.getAttribute("data-shared-call");
  if (!ticket || !address) return;
  void fetch(address + encodeURIComponent(ticket), { cache: "no-store" });
  ticket = "";
};

if (ticket) {
  const address = new URL(location.href);
  address.searchParams.delete(TICKET);
  history.replaceState(null, "", address);
}

whenChanged(() => {
  copyLinks();
  ask();
});
