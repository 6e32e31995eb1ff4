// @ts-check
// A small field over what is edited where it stands.

const MARGIN_PX = 2;

/**
 * @typedef {{
 *   name: string, label: string, value: string, isCentred: boolean,
 *   end: (isTaken: boolean) => void, goBack: () => void,
 * }} About `end` is called once, when the field is finished or given up; then `goBack`, if it had the
 *   focus; `name` is its class
 */

/**
 * Open a field over a place, with the focus in it; returned with what closes it.
 * @param {Element} place
 * @param {About} about
 */
export const openField = (place, { name, label, value, isCentred, end, goBack }) => {
  const field = document.createElement("input");
  field.className = name;
  field.setAttribute("aria-label", label);
  field.value = value;
  document.body.append(field);
  const box = place.getBoundingClientRect();
  const { width, height } = field.getBoundingClientRect();
  const left = isCentred ? box.left + box.width / 2 - width / 2 : box.left;
  const most = document.body.clientWidth - width - MARGIN_PX;
  field.style.left = `${Math.max(Math.min(left, most), MARGIN_PX)}px`;
  field.style.top = `${Math.max(box.top + box.height / 2 - height / 2, 0)}px`;
  field.focus();
  field.select();
  let isOpen = true;

  /** @param {boolean} isTaken */
  const close = (isTaken) => {
    if (!isOpen) return;
    isOpen = false;
    const hadFocus = document.activeElement === field;
    field.remove();
    end(isTaken);
    if (hadFocus) goBack();
  };
  // What is typed is no key of anything else.
  field.addEventListener("keydown", (event) => event.stopPropagation());
  return { field, close };
};
