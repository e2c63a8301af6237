"use strict";
/* Views of a sweep that somebody named: what its address said, kept in this browser. */
(function (foundry) {
  const {h, fill, announce} = foundry.dom;

  class Views {
    /** @param onShow called with what an address said behind the ? */
    constructor(sweep, onShow) {
      this.key = `foundry-views/${sweep}`;
      this.onShow = onShow;
      this.name = h("input", {placeholder: "Name of this view", "aria-label": "Name of this view"});
      this.list = h("ul");
      this.element = h("details", {class: "menu views-kept"}, h("summary", {}, "views"), h("div", {class: "menu-list"},
        h("form", {onsubmit: (event) => { event.preventDefault(); this.keep(); }}, this.name, h("button", {}, "Keep")), this.list));
      this.draw();
    }

    /** Return the views by name; none where the browser keeps nothing, or where something else stands in their place. */
    read() {
      try {
        const found = JSON.parse(localStorage.getItem(this.key));
        return new Map(Object.entries(found || {}).filter(([, query]) => typeof query === "string"));
      } catch (error) {
        if (!(error instanceof SyntaxError || error instanceof DOMException)) throw error;
        return new Map();
      }
    }

    write(views) {
      try {
        localStorage.setItem(this.key, JSON.stringify(Object.fromEntries(views)));
      } catch (error) {
        announce(`This browser keeps no views: ${error.message}`);
      }
      this.draw();
    }

    keep() {
      const name = this.name.value.trim();
      if (!name) return;
      this.write(this.read().set(name, foundry.address.read().toString()));
      this.name.value = "";
      announce(`The view ${name} is kept in this browser.`);
    }

    forget(name) {
      const views = this.read();
      views.delete(name);
      this.write(views);
    }

    draw() {
      const views = [...this.read()];
      fill(this.list, views.map(([name, query]) => h("li", {}, h("button", {type: "button", "data-view": name, onclick: () => this.onShow(query)}, name), " ",
        h("button", {type: "button", "aria-label": `Forget ${name}`, onclick: () => this.forget(name)}, "✕"))));
    }
  }

  foundry.Views = Views;
})(window.Foundry);
