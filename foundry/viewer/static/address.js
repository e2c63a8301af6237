"use strict";
/* Keeps the state of a page in its address, behind the ?, so that Back and a copied link restore the page. */
(function (foundry) {
  const WAIT_MS = 250;
  let waiting = {}, timer = null;

  const parts = () => location.hash.split("?");

  /** Return the part of the address after the ?. */
  function read() { return new URLSearchParams(parts().slice(1).join("?")); }

  /**
   * Change some keys in the address; null and "" remove a key.
   * @param push whether Back restores the previous view
   */
  function change(changes, {push = false} = {}) {
    const query = read();
    for (const [key, value] of Object.entries(changes)) {
      if (value === null || value === undefined || value === "") query.delete(key);
      else query.set(key, String(value));
    }
    replace(query, {push});
  }

  /** Replace all keys in the address. */
  function replace(query, {push = false} = {}) {
    const [path] = parts(), text = query.toString(), next = `${path || "#/"}${text ? `?${text}` : ""}`;
    if (next !== location.hash) history[push ? "pushState" : "replaceState"](null, "", next);
  }

  /** Change the address a little later, and only once for several calls, because playing and dragging change it often. */
  function remember(changes) {
    const here = location.hash;
    waiting = {...waiting, ...changes};
    clearTimeout(timer);
    timer = setTimeout(() => {
      if (location.hash === here) change(waiting);
      waiting = {};
    }, WAIT_MS);
  }

  // A user who opens another view, such as another step of the same run, must not be sent back.
  window.addEventListener("hashchange", () => {
    clearTimeout(timer);
    waiting = {};
  });

  foundry.address = {read, change};
  foundry.remember = remember;
})(window.Foundry);
