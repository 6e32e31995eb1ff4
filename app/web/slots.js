// @ts-check
// What the lab puts into templates is shown in the stage's slots of the same names.

import { whenChanged } from "./changes.js";
import { patch } from "./patch.js";

/** What each slot was last filled with. @type {WeakMap<Element, string>} */
const shown = new WeakMap();
let isPressed = false;

const fill = () => {
  // A link whose text is replaced between press and release is not clicked.
  if (isPressed) return;
  for (const slot of document.querySelectorAll("[data-slot-of]")) {
    const name = slot.getAttribute("data-slot-of");
    const source = document.querySelector(`template[data-slot="${name}"]`);
    const content = source?.innerHTML ?? "";
    if (shown.get(slot) === content) continue;
    shown.set(slot, content);
    const fresh = document.createElement("template");
    fresh.innerHTML = content;
    patch(slot, fresh.content);
  }
};

window.addEventListener("pointerdown", () => (isPressed = true), true);
for (const end of ["pointerup", "pointercancel", "blur"])
  window.addEventListener(end, () => {
    isPressed = false;
    // After the click, which comes last.
    setTimeout(fill);
  });
whenChanged(fill);
