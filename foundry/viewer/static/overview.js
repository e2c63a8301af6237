"use strict";
/* The page of a sweep: how far it is, its runs, why runs failed, what the analysis wrote. */
(function (foundry) {
  const {h, fill, badge} = foundry.dom;
  const POLL_MS = 1500;
  const IDLE_MS = 5000;
  const FILTERS = ["status", "model", "prompt"];
  const OPEN = ["running", "unfinished", "waiting"];

  /** Return how many runs stand how as a text, whatever order they were counted in. */
  function inOrder(counts) { return JSON.stringify(Object.entries(counts).sort()); }

  class Overview {
    constructor(sweeps, sweep, unreadable) {
      this.sweeps = sweeps;
      this.sweep = sweep;
      this.values = new Map();
      this.seen = new Map();
      this.table = new foundry.RunTable(sweep.id, {onPick: (runs) => this.picked(runs)});
      this.state = h("div", {class: "progress"});
      this.failures = h("div");
      this.links = h("div", {class: "links"});
      this.compare = h("a", {class: "button", hidden: true}, "Compare");
      this.controls = h("div", {class: "controls"});
      this.element = h("div", {class: "overview"}, this.heading(),
        unreadable.map((why) => h("p", {class: "warning"}, `Not shown: ${why}`)),
        this.state, this.links, this.failures, this.controls, this.table.element, this.table.pager);
    }

    dispose() { this.disposed = true; }

    heading() {
      const choice = h("select", {"aria-label": "Sweep", onchange: () => { location.hash = `#/sweep/${choice.value}`; }},
        this.sweeps.map((one) => h("option", {value: one.id, selected: one.id === this.sweep.id}, `${one.name} (${one.runs} runs)`)));
      return h("header", {class: "heading"}, h("h1", {}, this.sweep.name), this.sweeps.length > 1 ? choice : null,
        h("p", {class: "asked"}, h("code", {}, `foundry ${this.sweep.asked.join(" ")}`)));
    }

    async open() {
      await this.load();
      if (foundry.source.live) this.later();
      return this;
    }

    /** Look again by and by: runs go on, and when all have ended, an analysis or a report may be written. */
    later() {
      if (this.disposed) return;
      setTimeout(async () => {
        if (this.disposed) return;
        try {
          await this.load();
        } catch (error) {
          if (!this.isOpen()) return;
          fill(this.state, h("p", {class: "warning"}, `No news from the server: ${error.message}`));
        }
        this.later();
      }, this.isOpen() ? POLL_MS : IDLE_MS);
    }

    isOpen() { return this.rows.some((row) => OPEN.includes(row.status)); }

    async load() {
      const address = `sweep/${this.sweep.id}`;
      const before = this.head;
      this.head = await foundry.source.json(address);
      const rows = [];
      if (before && !this.isOpen() && inOrder(this.counted()) === inOrder(this.head.counts)) rows.push(...this.rows);
      for (let page = 0; rows.length < this.head.runs; page += 1) {
        rows.push(...(await foundry.source.json(`${address}/rows/${page}`)).rows);
        if (!this.rows) this.show(rows);
      }
      this.show(rows);
      if (!this.chosen || !this.chosen.length) this.chosen = this.head.shown;
      if (this.isNews("controls", [this.head.measures, FILTERS.map((key) => this.choices(key))])) this.drawControls();
      await this.loadMeasures();
    }

    show(rows) {
      rows.forEach((row, index) => {
        row.index = index;
        row.text = [row.run, row.model, row.prompt, row.world, row.form, row.seed, row.status, row.error || "", ...row.factors].join(" ").toLocaleLowerCase();
      });
      this.rows = rows;
      this.drawState();
      if (this.isNews("failures", rows.map((row) => row.error))) this.drawFailures();
      if (this.isNews("links", this.head.links)) this.drawLinks();
      if (this.isNews("rows", rows)) this.table.setRows(rows);
    }

    /** Return whether something is not as it was: what is as it was is not drawn again, so that nobody loses their place. */
    isNews(name, content) {
      const text = JSON.stringify(content), before = this.seen.get(name);
      this.seen.set(name, text);
      return text !== before;
    }

    async loadMeasures() {
      for (const name of this.chosen) {
        const index = this.head.measures.indexOf(name);
        if (index >= 0 && !this.values.has(name)) {
          this.values.set(name, (await foundry.source.json(`sweep/${this.sweep.id}/measure/${index}`)).values);
        }
      }
      if (this.isNews("columns", [this.chosen, this.head.factors, this.head.measures])) this.table.setColumns(this.columns());
    }

    columns() {
      const plain = (key, label = key) => ({key, label, value: (row) => row[key]});
      const differ = (key) => (new Set(this.rows.map((row) => row[key])).size > 1 ? [plain(key)] : []);
      return [
        plain("run"), plain("status"), plain("model"), plain("prompt"), ...differ("world"), ...differ("form"), plain("seed"),
        ...this.head.factors.map((name, index) => ({key: name, label: name, value: (row) => row.factors[index]})),
        {key: "undecided", label: "undecided", value: (row) => row.undecided},
        ...this.chosen.map((name) => ({key: name, label: name, value: (row) => (this.values.get(name) || [])[row.index] ?? null})),
      ];
    }

    /** Return how many of the rows that have come so far stand how. */
    counted() {
      const counts = {};
      this.rows.forEach((row) => { counts[row.status] = (counts[row.status] || 0) + 1; });
      return counts;
    }

    drawState() {
      const {runs} = this.head, counts = this.counted(), ended = (counts.complete || 0) + (counts.failed || 0);
      fill(this.state, h("progress", {max: String(runs), value: String(ended), "aria-label": "Runs that have ended"}),
        h("span", {}, `${ended} of ${runs} runs ended `), this.rows.length < runs ? h("span", {}, `(${this.rows.length} looked at so far) `) : null, Object.entries(counts).map(([word, count]) => [badge(word), ` ${count} `]));
    }

    drawFailures() {
      const causes = new Map();
      this.rows.filter((row) => row.error).forEach((row) => causes.set(row.error, [...(causes.get(row.error) || []), row]));
      fill(this.failures, causes.size ? h("details", {class: "failures", open: true}, h("summary", {}, `Why runs failed (${[...causes.values()].flat().length})`),
        h("ul", {}, [...causes].slice(0, 20).map(([cause, rows]) => h("li", {}, h("b", {}, `${rows.length} × `), h("bdi", {}, cause), " ",
          rows.slice(0, 5).map((row) => [h("a", {href: `#/run/${this.sweep.id}/${row.run}`}, row.run), " "]), rows.length > 5 ? "…" : null)))) : null);
    }

    drawLinks() {
      const link = (one) => h("a", {href: foundry.source.file(this.sweep.id, one.path), target: "_blank", rel: "noopener"}, one.path);
      const reports = this.head.links.filter((one) => one.kind === "html"), others = this.head.links.filter((one) => one.kind !== "html");
      fill(this.links, reports.map((one) => h("span", {class: "report"}, link(one))),
        others.length ? h("details", {}, h("summary", {}, `plots and tables (${others.length})`), h("ul", {}, others.map((one) => h("li", {}, link(one))))) : null);
    }

    choices(key) { return [...new Set(this.rows.map((row) => row[key]))].sort(); }

    drawControls() {
      const {filters} = this.table;
      const select = (key) => h("select", {"aria-label": `Only this ${key}`, "data-filter": key, onchange: (event) => this.table.filter({[key]: event.target.value})},
        h("option", {value: ""}, `every ${key}`), this.choices(key).map((value) => h("option", {value, selected: value === filters[key]}, value)));
      const search = h("input", {type: "search", placeholder: "Filter runs", "aria-label": "Filter runs", value: filters.text, oninput: () => this.table.filter({text: search.value})});
      fill(this.controls, search, FILTERS.map(select), this.measureChoice(), this.compare,
        h("button", {type: "button", onclick: () => this.compareSeed()}, "Compare the models on a seed"));
    }

    measureChoice() {
      if (!this.head.measures.length) return null;
      return h("details", {class: "menu"}, h("summary", {}, "signatures"), h("div", {class: "menu-list"}, this.head.measures.map((name) => {
        const tick = h("input", {type: "checkbox", checked: this.chosen.includes(name), onchange: () => {
          this.chosen = tick.checked ? [...this.chosen, name] : this.chosen.filter((one) => one !== name);
          this.loadMeasures();
        }});
        return h("label", {}, tick, ` ${name}`);
      })));
    }

    picked(runs) {
      this.compare.hidden = runs.length < 2;
      this.compare.textContent = runs.length > 4 ? "Compare the first four" : `Compare ${runs.length} runs`;
      this.compare.href = `#/compare/${this.sweep.id}/${runs.slice(0, 4).join("/")}`;
    }

    /** Go to the first seed, among the runs shown, that several models were run with under one prompt. */
    compareSeed() {
      const groups = new Map();
      for (const row of this.table.matching().filter((one) => one.status !== "waiting")) {
        const key = JSON.stringify([row.seed, row.prompt, row.world]);
        const group = groups.get(key) || [];
        if (!group.some((one) => one.model === row.model)) groups.set(key, [...group, row]);
      }
      const best = [...groups.values()].find((group) => group.length > 1);
      if (best) location.hash = `#/compare/${this.sweep.id}/${best.slice(0, 4).map((row) => row.run).join("/")}`;
      else foundry.dom.announce("No seed was run with two models.");
    }
  }

  foundry.Overview = Overview;
})(window.Foundry);
