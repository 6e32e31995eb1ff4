// @ts-check
// Texts with markup (legends, sentences, readings), where no style may stand in it: the policy of pages
// in frames lets scripts alone set styles.

/** What each place holds, so that nothing is made anew for nothing. @type {WeakMap<Element, string>} */
const held = new WeakMap();

/**
 * Put a text with markup into its place; what comes from people has been escaped by the lab.
 * @param {Element} place
 * @param {string} html
 */
export const put = (place, html) => {
  if (held.get(place) === html) return;
  held.set(place, html);
  // In what people wrote, quotes are escaped.
  const parsed = new DOMParser().parseFromString(html.replaceAll(' style="', ' data-style="'), "text/html");
  for (const node of /** @type {NodeListOf<HTMLElement>} */ (parsed.querySelectorAll("[data-style]"))) {
    node.style.cssText = node.dataset.style ?? "";
    delete node.dataset.style;
  }
  // Where no glossary is, words that are explained elsewhere are plain words.
  const isExplained = document.querySelector("[data-terms]") !== null;
  for (const term of isExplained ? [] : parsed.querySelectorAll('[role="term"]')) {
    term.removeAttribute("role");
    term.removeAttribute("tabindex");
  }
  place.replaceChildren(...document.adoptNode(parsed.body).childNodes);
};
