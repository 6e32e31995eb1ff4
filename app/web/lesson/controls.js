// @ts-check
// The few controls of a lesson: buttons, switches, choices, and sliders with named steps.

import { send, sendNewest } from "../player/pipe.js";
import { attribute, element, keep, write } from "../time/dom.js";
import { word } from "./words.js";

/** @typedef {import("./state.js").Control} Control */

/** More than this are a list to open. */
const MOST_SIDE_BY_SIDE = 3;

export const controlsNode = element("section", "controls");
const heading = element("h2", "");
const place = element("div", "all");
controlsNode.append(heading, place);

/** What controls stand for now, by their names. @type {Map<string, Control>} */
const now = new Map();

/** @param {string} control @param {unknown} value */
const use = (control, value) => send({ do: "use", control, value });

/** @param {Control} control */
export const useMain = ({ control, value }) => use(control, value ?? null);

/** @param {Control} control */
const indexOf = ({ options = [], value }) =>
  options.findIndex(([each]) => JSON.stringify(each) === JSON.stringify(value));

/** @param {Control} control */
const makeSlider = ({ control, label }) => {
  const node = element("label", "slider");
  const slider = document.createElement("input");
  slider.type = "range";
  slider.min = "0";
  slider.step = "1";
  const tell = (/** @type {typeof send | typeof sendNewest} */ say) => {
    const option = now.get(control)?.options?.[slider.valueAsNumber];
    if (!option) return;
    write(/** @type {Element} */ (node.querySelector("output")), option[1]);
    slider.setAttribute("aria-valuetext", option[1]);
    say({ do: "use", control, value: option[0] });
  };
  slider.addEventListener("input", () => tell(sendNewest));
  slider.addEventListener("change", () => tell(send));
  node.append(element("span", "", label), slider, document.createElement("output"));
  return node;
};

/** @param {Control} control */
const makeChoice = ({ control, label, options = [] }) => {
  if (options.length > MOST_SIDE_BY_SIDE) {
    const node = element("label", "list");
    const list = document.createElement("select");
    list.append(...options.map(([, text], at) => new Option(text, `${at}`)));
    list.addEventListener("change", () => use(control, now.get(control)?.options?.[Number(list.value)]?.[0]));
    node.append(element("span", "", label), list);
    return node;
  }
  const node = element("fieldset", "few");
  node.append(element("legend", "", label));
  options.forEach(([, text], at) => {
    const one = element("label", "");
    const box = document.createElement("input");
    box.type = "radio";
    box.name = control;
    box.value = `${at}`;
    box.addEventListener("change", () => use(control, now.get(control)?.options?.[at]?.[0]));
    one.append(box, element("span", "", text));
    node.append(one);
  });
  return node;
};

/** @param {Control} each */
const make = (each) => {
  if (each.kind === "slider") return makeSlider(each);
  if (each.kind === "choice") return makeChoice(each);
  const button = element("button", each.kind);
  button.setAttribute("type", "button");
  button.addEventListener("click", () => {
    const { kind, value, on, control } = now.get(each.control) ?? each;
    if (on) use(control, kind === "toggle" ? !value : (value ?? null));
  });
  return button;
};

/** @param {HTMLElement} node @param {Control} control */
const update = (node, control) => {
  now.set(control.control, control);
  attribute(node, "title", control.on ? null : (control.why ?? null));
  const { kind, label, options = [], value, on } = control;
  if (kind === "button" || kind === "toggle") {
    write(node, label);
    // What has the focus keeps it while it has nothing to do.
    attribute(node, "aria-disabled", on ? null : "true");
    attribute(node, "aria-pressed", kind === "toggle" ? `${Boolean(value)}` : null);
    return;
  }
  const at = indexOf(control);
  for (const input of /** @type {NodeListOf<HTMLInputElement | HTMLSelectElement>} */ (
    node.querySelectorAll("input, select")
  )) {
    input.disabled = !on;
    if (input instanceof HTMLInputElement && input.type === "radio") input.checked = input.value === `${at}`;
    else if (document.activeElement !== input) {
      if (kind === "slider") /** @type {HTMLInputElement} */ (input).max = `${options.length - 1}`;
      input.value = `${Math.max(at, 0)}`;
    }
  }
  if (kind !== "slider" || document.activeElement === node.querySelector("input")) return;
  const text = options[at]?.[1] ?? "";
  write(/** @type {Element} */ (node.querySelector("output")), text);
  attribute(/** @type {Element} */ (node.querySelector("input")), "aria-valuetext", text);
};

/**
 * @param {Control[]} controls
 * @param {Control | null} main what stands below the card as the thing to do
 */
export const showControls = (controls, main) => {
  const others = controls.filter((control) => control !== main);
  controlsNode.hidden = others.length === 0;
  write(heading, word("controls"));
  keep(
    place,
    others,
    ({ control, kind, label, options }) =>
      kind === "button" || kind === "toggle" ? `${control} ${kind}` : JSON.stringify([control, kind, label, options]),
    make,
    (node, control, at) => {
      node.style.order = `${at}`;
      update(node, control);
    },
  );
};
