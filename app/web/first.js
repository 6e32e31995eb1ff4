// @ts-check
// Stands in the page itself, before viser's own script; all else comes with lab.js.
{
  // Below a path, links and scripts are found only from a folder, and a browser may have been sent
  // to the folder's name without its slash.
  const { pathname, search, hash } = location;
  if (!pathname.endsWith("/") && !pathname.endsWith(".html")) {
    history.replaceState(null, "", `${pathname}/${search}${hash}`);
  }

  // What the page is to look like, and does from the first moment on (scheme.js).
  const { dataset } = document.documentElement;
  const chosen = localStorage.getItem("pounce-scheme");
  const isDark = matchMedia("(prefers-color-scheme: dark)").matches;
  dataset.wanted = chosen ?? (isDark ? "dark" : "light");

  /**
   * viser asks for its websocket at the folder's name without the slash. Proxies answer that with a
   * redirection, which no websocket follows.
   * @param {string} address
   */
  const asFolder = (address) =>
    address.endsWith("/") || address.includes("?") ? address : `${address}/`;

  // viser talks to the lab in a worker, and shows three dots whatever becomes of that.
  window.Worker = class extends Worker {
    /** @param {ConstructorParameters<typeof Worker>} parameters */
    constructor(...parameters) {
      super(...parameters);
      this.addEventListener("message", ({ data }) => {
        if (data?.type === "connected" || data?.type === "closed") {
          document.documentElement.dataset.connection = data.type;
          document.dispatchEvent(new CustomEvent("lab:connection", { detail: data.type }));
        }
      });
    }

    /**
     * @param {any} message
     * @param {any} [transfer]
     */
    postMessage(message, transfer) {
      const isAddress = message?.type === "set_server";
      const said = isAddress ? { ...message, server: asFolder(message.server) } : message;
      super.postMessage(said, transfer);
    }
  };
}
