"use strict";
/* Loads the data from script files next to the page, because a page opened from a file may not fetch. Each script contains gzip in base64. */
(function (foundry) {
  const waiting = new Map();

  foundry.received = (address, content) => {
    const entry = waiting.get(address);
    if (entry) entry.resolve(content);
  };

  function load(address) {
    if (!waiting.has(address)) {
      const entry = {};
      entry.promise = new Promise((resolve, reject) => {
        entry.resolve = resolve;
        const script = document.createElement("script");
        script.src = `data/${address}.js`;
        script.onload = () => { script.remove(); waiting.delete(address); };
        script.onerror = () => { waiting.delete(address); reject(new Error(`The exported page does not hold '${address}'.`)); };
        document.head.appendChild(script);
      });
      waiting.set(address, entry);
    }
    return waiting.get(address).promise;
  }

  async function bytes(address) {
    const packed = Uint8Array.from(atob(await load(address)), (sign) => sign.charCodeAt(0));
    const unpacked = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(unpacked).arrayBuffer();
  }

  foundry.source = {
    live: false,
    json: async (address) => JSON.parse(new TextDecoder().decode(await bytes(address))),
    bytes,
    file: (sweep, path) => `files/${sweep}/${path.split("/").map(encodeURIComponent).join("/")}`,
  };
})(window.Foundry);
