"use strict";
/* Loads the data from the server of the page. An exported page uses source_files.js instead. */
(function (foundry) {
  async function ask(address, options) {
    const response = await fetch(`data/${address}`, options);
    if (response.ok) return response;
    const answer = await response.json();
    throw new Error(answer.error);
  }

  foundry.source = {
    live: true,
    json: async (address) => (await ask(address)).json(),
    send: async (address, value) => (await ask(address, {method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify(value)})).json(),
    bytes: async (address) => (await ask(address)).arrayBuffer(),
    file: (sweep, path) => `files/${sweep}/${path.split("/").map(encodeURIComponent).join("/")}`,
  };
})(window.Foundry);
