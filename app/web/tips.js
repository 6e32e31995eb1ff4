// @ts-check
// What a dot, a point or a cell of the results is, at once under the pointer and where the keyboard
// is; the browser's own hints come late and not at all to a keyboard.

const CHARTS = ".pounce-results svg";
const GAP_PX = 10;

const tip = document.createElement("div");
tip.id = "pounce-tip";
tip.ariaHidden = "true";
tip.hidden = true;
document.body.append(tip);

/**
 * What a part of a chart is called; the browser is to give no hint of its own beside this one.
 * @param {Element} part
 */
const nameOf = (part) => {
  const title = part.querySelector(":scope > title");
  if (title) {
    part.setAttribute("aria-label", title.textContent ?? "");
    title.remove();
  }
  return part.getAttribute("aria-label") ?? "";
};

/**
 * What the dot of a row is that is nearest to the pointer; where there are very many, all dots of a
 * row are one path.
 * @param {Element} path
 * @param {PointerEvent} event
 */
const nearest = (path, { clientX, clientY }) => {
  if (!(path instanceof SVGPathElement)) return "";
  const { label = "", seeds = "", values = "" } = path.dataset;
  const inverse = path.getScreenCTM()?.inverse();
  if (!inverse || !seeds) return "";
  const at = new DOMPoint(clientX, clientY).matrixTransform(inverse);
  const places = [...(path.getAttribute("d") ?? "").matchAll(/M([\d.-]+) ([\d.-]+)/g)];
  const far = places.map(([, x, y]) => Math.hypot(at.x - Number(x), at.y - Number(y)));
  const index = far.indexOf(Math.min(...far));
  return `${label}, seed ${seeds.split(" ")[index]}: ${values.split(" ")[index]}`;
};

/**
 * @param {string} text
 * @param {{left: number, right: number, top: number, bottom: number}} place of what it is said of
 */
const show = (text, { left, right, top, bottom }) => {
  tip.hidden = !text;
  if (!text) return;
  tip.textContent = text;
  const { width, height } = tip.getBoundingClientRect();
  const x = Math.min(Math.max((left + right - width) / 2, 4), innerWidth - width - 4);
  const above = top - height - GAP_PX;
  tip.style.left = `${x}px`;
  tip.style.top = `${above > 4 ? above : bottom + GAP_PX}px`;
};
const hide = () => void (tip.hidden = true);

/** @param {Event} event */
const follow = ({ target }) => {
  const part = target instanceof Element ? target.closest(`${CHARTS} a`) : null;
  if (part) show(nameOf(part), (part.querySelector(".mark") ?? part).getBoundingClientRect());
  else hide();
};
document.addEventListener("pointerover", (event) => {
  const path = event.target instanceof Element ? event.target.closest(`${CHARTS} .dots`) : null;
  if (path) show(nearest(path, event), new DOMRect(event.clientX, event.clientY));
  else follow(event);
});
document.addEventListener("focusin", follow);
document.addEventListener("focusout", hide);
document.addEventListener("pointerdown", hide);
window.addEventListener("scroll", hide, true);
window.addEventListener("keydown", ({ key }) => {
  if (key === "Escape") hide();
});
