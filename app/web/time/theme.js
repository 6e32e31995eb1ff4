// @ts-check
// The frame looks like the page around it: its scheme, its colours and type, its size, whether it is
// presented, and what a lesson shows of it. All of it is taken over at once when it changes there.

const own = document.documentElement;
const around = window.parent.document.documentElement;
/** What the frame's styles use of those of viser's page. */
const NAMES = [
  "--mantine-color-body",
  "--mantine-color-text",
  "--mantine-color-dimmed",
  "--mantine-color-default",
  "--mantine-color-default-border",
  "--mantine-color-default-hover",
  "--mantine-color-dark-9",
  "--mantine-primary-color-filled",
  "--mantine-font-family",
  "--pounce-link",
  "--pounce-failed",
  "--stage-zoom",
];
const SCHEME = "data-mantine-color-scheme";

let shown = "";

const follow = () => {
  const scheme = around.getAttribute(SCHEME) ?? around.dataset.wanted ?? "light";
  const styles = getComputedStyle(around);
  const values = NAMES.map((name) => styles.getPropertyValue(name).trim());
  const { present, lessonShows } = around.dataset;
  const now = [scheme, present, lessonShows, ...values].join("\n");
  if (now === shown) return;
  shown = now;
  own.setAttribute(SCHEME, scheme);
  own.toggleAttribute("data-present", present !== undefined);
  if (lessonShows === undefined) delete own.dataset.lessonShows;
  else own.dataset.lessonShows = lessonShows;
  NAMES.forEach((name, place) => own.style.setProperty(name, values[place]));
};

new MutationObserver(follow).observe(around, {
  attributeFilter: [SCHEME, "data-present", "data-lesson-shows", "style"],
});
follow();
