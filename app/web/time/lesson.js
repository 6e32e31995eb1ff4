// @ts-check
// In a lesson the bar has but what its card names: what it does not is not there, or is for looking at
// alone.

const root = document.documentElement;

/** What there is of the bar by one of these, and what can be used by one of those. */
const THERE = /** @type {const} */ ([
  [".transport, .between, .live-end", ["scrub"]],
  [".row.curve, .legend", ["bar", "curve"]],
  [".lanes", ["bar", "plan"]],
  [".tree", ["scrub", "plan"]],
]);
const USED = /** @type {const} */ ([
  [".playhead, .events, .units", ["scrub"]],
  [".lanes", ["plan"]],
  [".marks", ["marks"]],
]);

const follow = () => {
  const shows = root.dataset.lessonShows?.split(" ");
  const has = (/** @type {readonly string[]} */ names) =>
    shows === undefined || names.some((name) => shows.includes(name));
  for (const [parts, names] of THERE)
    for (const node of document.querySelectorAll(parts)) node.toggleAttribute("data-untaught", !has(names));
  for (const [parts, names] of USED)
    for (const node of document.querySelectorAll(parts)) node.toggleAttribute("inert", !has(names));
  root.toggleAttribute("data-still", !has(["scrub"]));
};

new MutationObserver(follow).observe(root, { attributeFilter: ["data-lesson-shows"] });
follow();
