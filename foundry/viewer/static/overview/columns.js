"use strict";
/* The menu that chooses the measures to show as columns of the table. */
(function (foundry) {
  const {h, fill, breakable, grouped} = foundry.dom;
  const TWIN = "_readable";

  class Columns {
    /** @param onChoose called with the names of the chosen measures */
    constructor(onChoose) {
      this.onChoose = onChoose;
      this.search = h("input", {type: "search", placeholder: "find a measure", "aria-label": "Find a measure", oninput: () => this.draw()});
      this.twins = h("input", {type: "checkbox", onchange: () => this.draw()});
      this.list = h("div", {class: "families"});
      this.count = h("p", {class: "note", role: "status"});
      this.element = h("details", {class: "menu", ontoggle: () => this.draw()}, h("summary", {}, "columns"),
        h("div", {class: "menu-list"}, this.search, h("label", {}, this.twins, " also show measures that only count readable replies"), this.count, this.list));
    }

    set(measures, shown) {
      Object.assign(this, {measures, shown});
      this.element.hidden = !measures.length;
      this.draw();
    }

    draw() {
      if (!this.element.open) { fill(this.list); return; }
      const words = this.search.value.toLocaleLowerCase().split(/\s+/).filter(Boolean);
      const fits = (name) => (this.shown.includes(name) || this.twins.checked || !name.endsWith(TWIN)) && words.every((word) => name.includes(word));
      const names = this.measures.filter(fits), families = grouped(names, (name) => name.split(".")[0]);
      this.count.textContent = `${names.length} of ${this.measures.length} measures`;
      fill(this.list, [...families].map(([family, ofFamily]) => h("details", {open: Boolean(words.length) || ofFamily.some((name) => this.shown.includes(name))},
        h("summary", {}, `${family.replaceAll("_", " ")} (${ofFamily.length})`), ofFamily.map((name) => this.choice(name)))));
    }

    choice(name) {
      const tick = h("input", {type: "checkbox", checked: this.shown.includes(name), onchange: () => this.onChoose(
        tick.checked ? [...this.shown, name] : this.shown.filter((key) => key !== name))});
      return h("label", {}, tick, " ", breakable(name));
    }
  }

  foundry.Columns = Columns;
})(window.Foundry);
