"use strict";
/* What is looked at, behind the ? of the address: read, changed, and kept so that Back and a copied link bring it back. */
(function (foundry) {
  const WAIT_MS = 250;
  let waiting = {}, timer = null;

  const parts = () => location.hash.split("?");

  /** Return what the address says behind the ?. */
  function read() { return new URLSearchParams(parts().slice(1).join("?")); }

  /**
   * Change some of what the address says; null and "" leave a key out.
   * @param push whether Back is to bring back what was there before
   */
  function change(changes, {push = false} = {}) {
    const query = read();
    for (const [key, value] of Object.entries(changes)) {
      if (value === null || value === undefined || value === "") query.delete(key);
      else query.set(key, String(value));
    }
    replace(query, {push});
  }

  /** Change all of what the address says. */
  function replace(query, {push = false} = {}) {
    const [path] = parts(), text = query.toString(), next = `${path || "#/"}${text ? `?${text}` : ""}`;
    if (next !== location.hash) history[push ? "pushState" : "replaceState"](null, "", next);
  }

  /** Change what the address says a little later, once, however often it is called: playing and dragging change it fast. */
  function remember(changes) {
    const here = location.hash;
    waiting = {...waiting, ...changes};
    clearTimeout(timer);
    timer = setTimeout(() => {
      if (location.hash === here) change(waiting);
      waiting = {};
    }, WAIT_MS);
  }

  // Who goes elsewhere, be it to another step of the same run, is not to be led back.
  window.addEventListener("hashchange", () => {
    clearTimeout(timer);
    waiting = {};
  });

  foundry.address = {read, change};
  foundry.remember = remember;
})(window.Foundry);
