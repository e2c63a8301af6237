"use strict";
/* Searches the texts of all runs; every hit is a link to its moment. */
(function (foundry) {
  const {h, fill} = foundry.dom;
  const KINDS = {every: "every text", prompt: "prompts", reply: "replies", unreadable: "unreadable replies", reasoning: "reasoning", memory: "memory", message: "messages", note: "notes"};
  const AGAIN_MS = 400;

  class Find {
    /**
     * @param onChange called with what the address is to say of the search
     * @param nameOf returns what a run is called
     */
    constructor(sweep, onChange, nameOf) {
      Object.assign(this, {sweep, nameOf});
      const label = "Search in prompts, replies, reasoning, memory, messages, notes";
      this.words = h("input", {type: "search", placeholder: `${label}: words, fire*, "a phrase"`, "aria-label": label});
      this.kind = h("select", {"aria-label": "Where to search"}, Object.entries(KINDS).map(([kind, label]) => h("option", {value: kind}, label)));
      this.state = h("p", {class: "note", role: "status"});
      this.list = h("ol", {class: "found"});
      this.element = h("section", {class: "find", "aria-label": "Search in all runs"},
        h("form", {onsubmit: (event) => { event.preventDefault(); onChange({find: this.words.value.trim(), in: this.kind.value === "every" ? null : this.kind.value}); }},
          this.words, this.kind, h("button", {}, "Search")), this.state, this.list);
    }

    dispose() { clearTimeout(this.waiting); this.asked = null; }

    /** Show what the address asks for: texts of a kind with these words, of a model and a world; unreadable replies need no word. */
    show(search) {
      const asked = search.words || search.kind === "unreadable" ? encodeURIComponent(JSON.stringify(search)) : "";
      if (asked === this.asked) return;
      this.asked = asked;
      clearTimeout(this.waiting);
      this.words.value = search.words;
      this.kind.value = search.kind;
      fill(this.list);
      this.state.textContent = asked ? "Searching…" : "";
      if (asked) this.ask(asked);
    }

    async ask(asked) {
      try {
        const found = await foundry.source.json(`sweep/${this.sweep}/search/${asked}`);
        if (this.asked !== asked) return;
        const ready = found.indexed >= found.runs, many = `${found.more ? "more than " : ""}${found.count.toLocaleString("en")} found`;
        this.state.textContent = `${many}${found.count > found.hits.length ? `, the first ${found.hits.length} of them` : ""}${ready ? "" : `; ${found.indexed} of ${found.runs} runs read so far`}${found.unread.length ? `; not read: ${found.unread.join("; ")}` : ""}`;
        fill(this.list, found.hits.map((hit) => this.item(hit)));
        if (!ready) this.waiting = setTimeout(() => this.ask(asked), AGAIN_MS);
      } catch (error) {
        if (this.asked === asked) this.state.textContent = error.message;
      }
    }

    item([run, step, agent, kind, text, moment]) {
      const at = Object.entries({step, agent}).filter(([, number]) => number !== null);
      return h("li", {}, h("a", {href: foundry.Notes.addressOf(this.sweep, {run, step, agent, moment})}, [this.nameOf(run), ...at.map((one) => one.join(" "))].join(" · ")), this.kind.value === kind ? " " : ` ${kind}: `, h("bdi", {}, text));
    }
  }

  foundry.Find = Find;
})(window.Foundry);
