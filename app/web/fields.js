// @ts-check
// A number that is finished, by Enter or as the focus leaves, is sent at once, with a line break.
//
// viser sends keystrokes, some with a delay, and of several fields only the last one. All fields for
// text are for numbers, unless it is said that they are for a name.

const typed = new WeakSet();

/** @param {EventTarget | null} target */
const finish = (target) => {
  if (!(target instanceof HTMLInputElement) || !typed.delete(target)) return;
  const row = target.closest(".mantine-Flex-root");
  const label = row?.querySelector("label[for]");
  const isName = row?.parentElement?.previousElementSibling?.querySelector(".pounce-name");
  if (isName || !(label instanceof HTMLLabelElement)) return;
  /** @type {any} */ (window).__viserMutable?.sendMessage?.({
    type: "GuiUpdateMessage",
    uuid: label.htmlFor,
    updates: { value: `${target.value}\n` },
  });
};

/**
 * What is typed into a list finds its options, and is none where there is none of that name: then the
 * list shows again what is chosen, which viser has it do as the focus leaves.
 * @param {KeyboardEvent} event
 */
const leaveList = ({ key, target }) => {
  if (!(target instanceof HTMLInputElement) || !target.matches(".mantine-Select-input")) return;
  const list = document.getElementById(target.getAttribute("aria-controls") ?? "");
  const isOffered = list?.querySelector("[role=option]") != null;
  if (key === "Escape" || (key === "Enter" && list && !isOffered)) target.blur();
};

document.addEventListener("input", ({ target }) => {
  if (target instanceof HTMLElement && target.matches(".mantine-TextInput-input"))
    typed.add(target);
});
document.addEventListener("focusout", ({ target }) => finish(target));
document.addEventListener("keydown", (event) => {
  if (event.key === "Enter" && !event.isComposing) finish(event.target);
  leaveList(event);
});
