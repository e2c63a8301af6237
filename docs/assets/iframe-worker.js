/* The search of the site runs in a worker. A page that was opened from a file may start none, so a frame takes its place. */
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      document.body.append(frame);
      this.loaded = new Promise((resolve) => { frame.contentWindow.resolveLoaded = resolve; });
      this.inside = frame.contentWindow;
      window.addEventListener("message", (event) => {
        if (event.source === this.inside) this.dispatchEvent(new MessageEvent("message", {data: event.data}));
      });
      this.inside.importScripts = (...scripts) => scripts.reduce((before, script) => before.then(() => this.load(script)), Promise.resolve());
      this.inside.eval("postMessage = (data) => parent.postMessage(data, '*')");
      this.base = new URL(url, location);
      this.load("").then(() => this.inside.resolveLoaded());
    }
    load(url) {
      return new Promise((resolve, reject) => {
        const script = this.inside.document.createElement("script");
        Object.assign(script, {src: new URL(url, this.base).href, onload: resolve, onerror: reject});
        this.inside.document.body.append(script);
      });
    }
    postMessage(data) {
      this.loaded.then(() => this.inside.dispatchEvent(new MessageEvent("message", {data})));
    }
    terminate() {}
  };
}
