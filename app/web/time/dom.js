// @ts-check
// Elements that are kept: what has the focus or is in a hand stays the same one while what it shows
// changes.

/** Elements by their keys, of each parent. @type {WeakMap<Element, Map<string, HTMLElement>>} */
const kept = new WeakMap();

/**
 * Have one element in a parent for each item, the former one where there is one of its key. New ones
 * come last; none is moved, for that would take its focus away.
 * @template T
 * @param {Element} parent
 * @param {T[]} items
 * @param {(item: T) => string} keyOf
 * @param {(item: T) => HTMLElement} make
 * @param {(element: HTMLElement, item: T, index: number) => void} update
 */
export const keep = (parent, items, keyOf, make, update) => {
  const former = kept.get(parent) ?? new Map();
  /** @type {Map<string, HTMLElement>} */
  const now = new Map();
  items.forEach((item, index) => {
    const key = keyOf(item);
    if (now.has(key)) return;
    const element = former.get(key) ?? parent.appendChild(make(item));
    now.set(key, element);
    update(element, item, index);
  });
  for (const [key, element] of former) if (!now.has(key)) element.remove();
  kept.set(parent, now);
};

/**
 * @param {string} tag
 * @param {string} className
 * @param {string} [text]
 */
export const element = (tag, className, text = "") => {
  const made = document.createElement(tag);
  made.className = className;
  made.textContent = text;
  return made;
};

/**
 * @param {Element} element
 * @param {string} text
 */
export const write = (element, text) => {
  if (element.textContent !== text) element.textContent = text;
};

/**
 * An attribute, or none where it is null.
 * @param {Element} element
 * @param {string} name
 * @param {string | null} value
 */
export const attribute = (element, name, value) => {
  if (value === null) element.removeAttribute(name);
  else if (element.getAttribute(name) !== value) element.setAttribute(name, value);
};

/** @param {number} share */
export const percent = (share) => `${Math.round(share * 1e4) / 100}%`;

/**
 * Let an element reach from one place to another.
 * @param {HTMLElement} element
 * @param {number} first
 * @param {number} until
 */
export const reach = ({ style }, first, until) => {
  style.left = percent(first);
  style.width = percent(Math.max(until - first, 0));
};

/** @param {number} number */
export const grouped = (number) => Math.round(number).toLocaleString("en-US");
