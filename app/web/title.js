// @ts-check
// The tab is called what the lab's own HTML says: the text of the attribute `data-tab-title`.

const SOURCE = "[data-tab-title]";

const name = () => {
  const title = document.querySelector(SOURCE)?.getAttribute("data-tab-title");
  if (title && title !== document.title) document.title = title;
};

new MutationObserver(name).observe(document.body, {
  attributeFilter: ["data-tab-title"],
  childList: true,
  subtree: true,
});
name();
