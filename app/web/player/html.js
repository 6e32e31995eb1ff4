// @ts-check
// Texts that come as HTML (legends, sentences, readings) in pages whose policy lets no style stand in
// HTML: it is set by script, which is allowed.

/** No text has this in it: quotes are escaped there. */
const STYLE = / style="/g;

/**
 * Put HTML into an element, with the styles that stand in it; nothing happens if it is there already.
 * @param {HTMLElement} element
 * @param {string} html made by the lab, which has escaped what is written in it
 */
export const fill = (element, html) => {
  if (filled.get(element) === html) return;
  filled.set(element, html);
  element.innerHTML = html.replace(STYLE, ' data-style="');
  for (const part of /** @type {Iterable<HTMLElement>} */ (element.querySelectorAll("[data-style]"))) {
    part.style.cssText = part.dataset.style ?? "";
    part.removeAttribute("data-style");
  }
};

/** What was put where. @type {WeakMap<HTMLElement, string>} */
const filled = new WeakMap();
