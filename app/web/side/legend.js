// @ts-check
// A legend as the lab writes it, with styles in it, which a page that allows none in its text gets one
// by one.

/** What each place was filled with last. @type {WeakMap<Element, string>} */
const shown = new WeakMap();

/**
 * @param {Element} place
 * @param {string} html made by the lab, which escapes all names
 */
export const legendInto = (place, html) => {
  if (shown.get(place) === html) return;
  shown.set(place, html);
  // A document of its own heeds no style, and complains of none.
  const parsed = new DOMParser().parseFromString(html.replaceAll(" style=", " data-style="), "text/html");
  for (const node of parsed.querySelectorAll("[data-style]")) {
    const style = node.getAttribute("data-style") ?? "";
    node.removeAttribute("data-style");
    /** @type {HTMLElement} */ (node).style.cssText = style;
  }
  place.replaceChildren(...parsed.body.childNodes);
};
