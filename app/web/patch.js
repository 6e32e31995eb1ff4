// @ts-check
// HTML that is sent again and again takes the place of the former without what is alike being made
// anew: what has the focus, is pointed at or is explained stays what it was.

/**
 * @param {Element} old
 * @param {Element} fresh
 */
const patchElement = (old, fresh) => {
  for (const { name } of [...old.attributes]) if (!fresh.hasAttribute(name)) old.removeAttribute(name);
  for (const { name, value } of fresh.attributes)
    if (old.getAttribute(name) !== value) old.setAttribute(name, value);
  patch(old, fresh);
};

/**
 * Let a node have the children of another one, which loses them.
 * @param {Element} old
 * @param {Element | DocumentFragment} fresh
 */
export const patch = (old, fresh) => {
  const wanted = [...fresh.childNodes];
  wanted.forEach((node, place) => {
    const there = old.childNodes[place];
    if (!there) old.append(node);
    else if (there.isEqualNode(node)) return;
    else if (there instanceof Element && node instanceof Element && there.tagName === node.tagName)
      patchElement(there, node);
    else there.replaceWith(node);
  });
  while (old.childNodes.length > wanted.length) old.lastChild?.remove();
};
