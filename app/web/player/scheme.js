// @ts-check
// Dark or light: as the system has it, until somebody switches.

const root = document.documentElement;
const SCHEME = "data-mantine-color-scheme";
const wish = matchMedia("(prefers-color-scheme: dark)");
/** @type {Array<() => void>} */
const works = [];

export const isDark = () => root.getAttribute(SCHEME) === "dark";

/** @param {boolean} dark */
const set = (dark) => {
  root.setAttribute(SCHEME, dark ? "dark" : "light");
  for (const work of works) work();
};

export const switchScheme = () => set(!isDark());

/**
 * Do something whenever it is switched.
 * @param {() => void} work
 */
export const whenScheme = (work) => void works.push(work);

wish.addEventListener("change", ({ matches }) => set(matches));
set(wish.matches);
