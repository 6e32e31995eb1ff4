// @ts-check
// Keys act by their place on the keyboard, as in the lab, but not while something else wants them.

/**
 * Have keys do something; each is named by its place, with "Shift+" before it if it takes that.
 * @param {Record<string, () => unknown>} acts
 */
export const onKeys = (acts) => {
  addEventListener("keydown", (event) => {
    const { code, shiftKey, ctrlKey, metaKey, altKey, target } = event;
    if (ctrlKey || metaKey || altKey || event.defaultPrevented || !(target instanceof Element)) return;
    if (target.closest("input, select, textarea")) return;
    // What has the focus is pressed by space, and has ends of its own.
    if (code === "Space" && target.closest("button, summary, [role=button]")) return;
    const act = acts[shiftKey ? `Shift+${code}` : code];
    if (!act) return;
    event.preventDefault();
    act();
  });
};
