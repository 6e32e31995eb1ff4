// @ts-check
// A text that is finished, by Enter or as the focus leaves, is sent at once, with a line break.
//
// viser sends keystrokes, some with a delay, and of several fields only the last one.

const typed = new WeakSet();

/** @param {EventTarget | null} target */
const finish = (target) => {
  if (!(target instanceof HTMLInputElement) || !typed.delete(target)) return;
  const label = target.closest(".mantine-Flex-root")?.querySelector("label[for]");
  if (!(label instanceof HTMLLabelElement)) return;
  /** @type {any} */ (window).__viserMutable?.sendMessage?.({
    type: "GuiUpdateMessage",
    uuid: label.htmlFor,
    updates: { value: `${target.value}\n` },
  });
};

document.addEventListener("input", ({ target }) => {
  if (target instanceof HTMLElement && target.matches(".mantine-TextInput-input"))
    typed.add(target);
});
document.addEventListener("focusout", ({ target }) => finish(target));
document.addEventListener("keydown", (event) => {
  if (event.key === "Enter" && !event.isComposing) finish(event.target);
});
