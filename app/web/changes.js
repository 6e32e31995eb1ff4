// @ts-check
// Work that is to be done again whenever viser has changed the page.

const REST_MS = 100;
/** @type {Array<() => void>} */
const works = [];
let isDue = false;

/**
 * Do something now, and soon after each change of the page.
 * @param {() => void} work
 */
export const whenChanged = (work) => {
  works.push(work);
  work();
};

new MutationObserver(() => {
  if (isDue) return;
  isDue = true;
  setTimeout(() => {
    isDue = false;
    for (const work of works) work();
  }, REST_MS);
}).observe(document.body, {
  // three.js marks its canvas a while after it has come.
  attributeFilter: ["data-board", "data-engine"],
  characterData: true,
  childList: true,
  subtree: true,
});
