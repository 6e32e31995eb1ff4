// @ts-check
// Dark or light, as the device is.

const query = window.matchMedia("(prefers-color-scheme: dark)");

export const isDark = () => query.matches;

const show = () =>
  document.documentElement.setAttribute("data-mantine-color-scheme", isDark() ? "dark" : "light");

/**
 * @param {() => void} act
 */
export const whenChanged = (act) =>
  query.addEventListener("change", () => {
    show();
    act();
  });

show();
