// @ts-check
// Work that is to be done again whenever viser has changed the page.

const REST_MS = 100;
/** @type {Array<() => void>} */
const works = [];
let isDue = false;
let doneAt = -REST_MS;

/**
 * Do something now, at once after a change of a page that was at rest, and soon after each other one.
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
    doneAt = performance.now();
    for (const work of works) work();
  }, Math.max(doneAt + REST_MS - performance.now(), 0));
}).observe(document.body, {
  // three.js marks its canvas a while after it has come.
  attributeFilter: ["data-board", "data-engine"],
  characterData: true,
  childList: true,
  subtree: true,
});
