"use strict";
/* Searches the texts of all runs that match the filter. Every result is a link to its moment. */
(function (foundry) {
  const {h, fill} = foundry.dom;
  const KINDS = {every: "every text", prompt: "prompts", reply: "replies", unreadable: "unreadable replies", reasoning: "reasoning", memory: "memory", message: "messages", note: "notes"};
  const OUTCOMES = ["chosen", "repaired", "unreadable", "empty", "truncated", "failed"];
  const NUMBERS = {agent: "by agent", from: "from step", to: "to step"};
  const AGAIN_MS = 400;

  class Find {
    /**
     * @param onChange called with the part of the address that describes the search
     * @param onFound called with the number of results by run, or null if there is no search
     * @param nameOf returns the name of a run
     */
    constructor(sweep, {onChange, onFound, nameOf}) {
      Object.assign(this, {sweep, onChange, onFound, nameOf, asked: "", inRuns: null});
      this.words = h("input", {type: "search", placeholder: "words, fire*, \"a phrase\", tag:odd", "aria-label": "Filter and search",
        oninput: () => onChange({q: this.words.value, find: null, page: null}, false)});
      this.kind = this.choice("in", "Where to search", Object.entries(KINDS), "every");
      this.outcome = this.choice("outcome", "Outcome of the decision", [["", "every outcome"], ...OUTCOMES.map((name) => [name, name])], "");
      this.numbers = Object.entries(NUMBERS).map(([key, text]) => h("input", {type: "number", min: "0", placeholder: text, "aria-label": text, "data-find": key,
        oninput: (event) => onChange({[key]: event.target.value || null, page: null}, false)}));
      this.state = h("p", {class: "note", role: "status"});
      this.speakers = h("p", {class: "speakers"});
      this.list = h("ol", {class: "found"});
      this.more = h("button", {type: "button", hidden: true, onclick: () => this.ask(this.asked, this.list.children.length)}, "Load more");
      this.filters = h("span", {class: "filters"});
      this.form = h("form", {onsubmit: (event) => { event.preventDefault(); onChange({find: this.words.value.trim(), q: null, page: null}); }},
        this.words, foundry.source.live ? [h("button", {}, "Search texts"), this.kind, this.outcome, this.numbers] : null, this.filters);
      this.element = h("section", {class: "find", "aria-label": "Runs and texts"}, this.form, this.state, this.speakers, this.list, this.more);
    }

    choice(key, label, options, none) {
      const select = h("select", {"aria-label": label, "data-find": key, onchange: () => this.onChange({[key]: select.value === none ? null : select.value, page: null})},
        options.map(([value, text]) => h("option", {value}, text)));
      return select;
    }

    dispose() { clearTimeout(this.waiting); this.asked = null; }

    /** Set the fields from the address. */
    restore(query) {
      const get = (key) => query.get(key) || "";
      if (document.activeElement !== this.words) this.words.value = get("find") || get("q");
      this.kind.value = get("in") || "every";
      this.outcome.value = get("outcome");
      this.numbers.forEach((field) => { field.value = get(field.dataset.find); });
    }

    /** Run the search that the address describes. */
    show(query, mask) {
      const get = (key) => query.get(key) || "", whole = (key) => (get(key) === "" ? null : Number(get(key)));
      const search = {kind: this.kind.value, words: get("find"), outcome: get("outcome"), agent: whole("agent"), first: whole("from"), last: whole("to")};
      const meant = foundry.source.live && (search.words || Object.entries(search).some(([key, value]) => key !== "words" && value !== null && value !== "" && value !== "every"));
      const asked = meant ? JSON.stringify({...search, runs: mask}) : "";
      if (asked === this.asked) return;
      this.asked = asked;
      clearTimeout(this.waiting);
      fill(this.list);
      fill(this.speakers);
      this.more.hidden = true;
      this.state.textContent = asked ? "Searching…" : "";
      if (asked) this.ask(asked, 0);
      else if (this.inRuns) { this.inRuns = null; this.onFound(); }
    }

    async ask(asked, skip) {
      try {
        const reply = await foundry.source.json(`sweep/${this.sweep}/search/${encodeURIComponent(JSON.stringify({...JSON.parse(asked), skip}))}`);
        if (this.asked === asked) this.draw(asked, skip, reply);
      } catch (error) {
        if (this.asked === asked) this.state.textContent = error.message;
      }
    }

    draw(asked, skip, reply) {
      const ready = reply.indexed >= reply.runs;
      if (!skip) fill(this.list);
      this.list.append(...reply.hits.map((hit) => this.item(hit)));
      const count = this.list.children.length;
      this.more.hidden = count >= reply.count || !ready;
      this.state.textContent = [`${reply.count.toLocaleString("en")} found in ${Object.keys(reply.in_runs).length} runs${reply.count > count ? `, the first ${count} are below` : ""}`,
        ready ? "" : `${reply.indexed} of ${reply.runs} runs read so far`, reply.unread.length ? `could not be read: ${reply.unread.join("; ")}` : ""].filter(Boolean).join("; ");
      fill(this.speakers, reply.agents.length ? ["Found most often in texts of ", reply.agents.map(([agent, hits]) => [h("button", {type: "button", class: "go", "aria-label": `Only agent ${agent}`,
        onclick: () => this.onChange({agent})}, `agent ${agent}: ${hits.toLocaleString("en")}`), " "])] : null);
      if (JSON.stringify(reply.in_runs) !== JSON.stringify(this.inRuns)) { this.inRuns = reply.in_runs; this.onFound(); }
      if (!ready) this.waiting = setTimeout(() => this.ask(asked, 0), AGAIN_MS);
    }

    item([run, step, agent, kind, text, moment]) {
      const at = Object.entries({step, agent}).filter(([, number]) => number !== null);
      return h("li", {}, h("a", {href: foundry.Notes.addressOf(this.sweep, {run, step, agent, moment})}, [this.nameOf(run), ...at.map((pair) => pair.join(" "))].join(" · ")), this.kind.value === kind ? " " : ` ${kind}: `, h("bdi", {}, text));
    }
  }

  foundry.Find = Find;
})(window.Foundry);
