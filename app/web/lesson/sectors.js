// @ts-check
// Parts of the board, chosen on a compass: what a click on the board does as well.

import { OCTANTS } from "../player/octants.js";
import { element } from "../time/dom.js";
import { RADII, compass, svgElement, wedge } from "./compass.js";
import { word } from "./words.js";

/** @type {import("./ask.js").Maker} */
export const sectors = (_, give) => {
  const node = element("div", "sectors");
  node.append(element("p", "where", word("onBoard")));
  const svg = compass();
  svg.setAttribute("role", "group");
  svg.setAttribute("aria-label", word("octants"));
  /** @type {Set<string>} */
  let chosen = new Set();
  const said = element("p", "chosen");

  /** @param {string} octant */
  const toggle = (octant) => {
    const next = new Set(chosen);
    if (!next.delete(octant)) next.add(octant);
    // The next click may come before this is drawn.
    chosen = next;
    give(OCTANTS.filter((each) => next.has(each)));
  };

  const parts = OCTANTS.map((octant, index) => {
    const part = svgElement("path", {
      d: wedge(index, RADII.prey, RADII.outer),
      role: "checkbox",
      tabindex: 0,
      class: "part",
      "aria-label": word(octant),
      "aria-checked": "false",
    });
    part.append(svgElement("title"));
    /** @type {Element} */ (part.firstElementChild).textContent = word(octant);
    part.addEventListener("click", () => toggle(octant));
    part.addEventListener("keydown", (event) => {
      const { key } = /** @type {KeyboardEvent} */ (event);
      const by = { ArrowLeft: 1, ArrowUp: 1, ArrowRight: -1, ArrowDown: -1 }[key];
      if (key !== " " && key !== "Enter" && !by) return;
      event.preventDefault();
      event.stopPropagation();
      if (by) /** @type {SVGElement} */ (parts[(index + by + OCTANTS.length) % OCTANTS.length]).focus();
      else toggle(octant);
    });
    svg.append(part);
    return part;
  });
  node.append(svg, said);
  return {
    node,
    show: (answer) => {
      chosen = new Set(answer ?? []);
      const isLocked = node.closest("fieldset")?.disabled ?? false;
      parts.forEach((part, index) => {
        part.setAttribute("aria-checked", `${chosen.has(OCTANTS[index])}`);
        // A fieldset locks what is in forms alone.
        part.toggleAttribute("data-locked", isLocked);
        if (isLocked) {
          part.setAttribute("aria-disabled", "true");
          part.removeAttribute("tabindex");
        } else {
          part.removeAttribute("aria-disabled");
          part.setAttribute("tabindex", "0");
        }
      });
      const names = OCTANTS.filter((octant) => chosen.has(octant)).map((octant) => word(octant));
      said.textContent = names.join("; ") || word("none");
    },
  };
};
