"use strict";
/* Searches the messages of a run, chunk by chunk, and shows results as they come. */
(function (foundry) {
  const {h, fill} = foundry.dom;
  const MOST = 200;

  class Search {
    /** @param onPick called with the step and the agent of a text */
    constructor(data, label, onPick) {
      this.data = data;
      this.onPick = onPick;
      this.input = h("input", {type: "search", placeholder: label, "aria-label": label});
      this.state = h("p", {class: "note", role: "status"});
      this.list = h("ol", {class: "found"});
      this.element = h("section", {class: "search", "aria-label": "Search", hidden: true},
        h("form", {onsubmit: (event) => { event.preventDefault(); this.run(); }}, this.input, h("button", {}, "Search")), this.state, this.list);
    }

    focus() {
      this.element.hidden = false;
      this.input.focus();
    }

    async run() {
      const wanted = this.input.value.trim().toLocaleLowerCase(), turn = this.turn = (this.turn || 0) + 1;
      fill(this.list);
      this.state.textContent = "";
      if (!wanted) return;
      const size = this.data.about.steps_per_chunk, chunks = Math.ceil(this.data.done / size);
      let count = 0;
      try {
        for (let chunk = 0; chunk < chunks && count < MOST; chunk += 1) {
          this.state.textContent = `${count} found, searching step ${chunk * size + 1} of ${this.data.done}`;
          const {texts} = await this.data.texts(chunk);
          if (turn !== this.turn) return;
          const hits = texts.filter((row) => row[2].toLocaleLowerCase().includes(wanted)).slice(0, MOST - count);
          hits.forEach((hit) => this.list.append(this.item(hit, wanted)));
          count += hits.length;
        }
        this.state.textContent = `${count} found${count >= MOST ? "; there may be more" : ""}`;
      } catch (error) {
        this.state.textContent = error.message;
      }
    }

    item([step, agent, text], wanted) {
      const at = text.toLocaleLowerCase().indexOf(wanted), from = Math.max(0, at - 60);
      const part = (from ? "…" : "") + text.slice(from, at + wanted.length + 100);
      return h("li", {}, h("button", {type: "button", onclick: () => this.onPick(step, agent)}, `step ${step} · agent ${agent}: `, h("bdi", {}, part)));
    }
  }

  foundry.Search = Search;
})(window.Foundry);
