"use strict";
/* The page of a sweep: how far it is, its runs, why runs failed, what the analysis wrote. */
(function (foundry) {
  const {h, fill, badge} = foundry.dom;
  const POLL_MS = 1500;
  const IDLE_MS = 5000;
  const FILTERS = ["status", "model", "prompt", "world"];
  const MOST_SHOWN = 6;
  const OPEN = ["running", "unfinished", "waiting"];
  const KEYS = [["/", "filter the runs"], ...foundry.source.live ? [["N", "the notes of the run in whose row the keyboard is"]] : []];

  /** Return how many runs stand how as a text, whatever order they were counted in. */
  function inOrder(counts) { return JSON.stringify(Object.entries(counts).sort()); }

  /** Return what leads to the other sweeps, or null where there is none. */
  function sweepChoice(sweeps, sweep) {
    const choice = h("select", {"aria-label": "Sweep", onchange: () => { location.hash = `#/sweep/${choice.value}`; }},
      sweeps.map((one) => h("option", {value: one.id, selected: one.id === sweep.id}, `${one.name} (${one.runs} runs)`)));
    return sweeps.length > 1 ? choice : null;
  }

  class Overview {
    constructor(sweeps, sweep, unreadable, query) {
      this.sweeps = sweeps;
      this.sweep = sweep;
      this.query = query;
      this.values = new Map();
      this.seen = new Map();
      this.matching = [];
      this.find = new foundry.Find(sweep.id, (changes) => this.change(changes), (run) => this.nameOf(run));
      this.noted = new foundry.Noted(sweep.id, {onChange: () => this.loadNotes(), onTag: (tag) => this.change({q: `tag:${tag}`, page: null})});
      this.summary = new foundry.Summary((group) => this.change({group, page: null}), (measure) => this.sortBy(measure));
      this.table = new foundry.RunTable(sweep.id, {
        onTick: (run) => this.tick(run), onChange: (changes) => this.change(changes), onDraw: (rows) => { this.matching = rows; }});
      this.state = h("div", {class: "progress"});
      this.failures = h("div");
      this.unread = h("div", {class: "unread"});
      this.links = h("div", {class: "links"});
      this.compare = h("a", {class: "button", hidden: true}, "Compare");
      this.search = h("input", {type: "search", placeholder: "Filter runs", "aria-label": "Filter runs", oninput: () => this.change({q: this.search.value, page: null}, false)});
      this.choosing = h("div", {class: "choosing"});
      this.controls = h("div", {class: "controls"}, this.search, this.choosing, foundry.dom.keys(KEYS));
      this.onKeyDown = (event) => this.key(event);
      document.addEventListener("keydown", this.onKeyDown);
      this.element = h("div", {class: "overview"}, this.heading(),
        unreadable.map((why) => h("p", {class: "warning"}, `Not shown: ${why}`)),
        this.state, this.links, this.failures, this.unread, this.noted.told, this.summary.element, foundry.source.live ? this.find.element : null, this.controls, this.table.element, this.table.pager, this.noted.element);
    }

    dispose() {
      this.disposed = true;
      this.find.dispose();
      document.removeEventListener("keydown", this.onKeyDown);
    }

    key(event) {
      const run = event.target.closest("tr[data-run]")?.dataset.run;
      if (foundry.dom.isTyping(event)) return;
      if (event.key === "/") this.search.focus();
      else if (event.key === "n" && run && foundry.source.live) this.noted.open(run);
      else return;
      event.preventDefault();
    }

    heading() {
      return h("header", {class: "heading"}, h("h1", {}, this.sweep.name), sweepChoice(this.sweeps, this.sweep),
        h("details", {class: "asked"}, h("summary", {}, "command"), h("code", {}, `foundry ${this.sweep.asked.join(" ")}`)));
    }

    /** Be ready once the first runs are there; the others come while these are looked at. */
    async open() {
      this.lookAsAsked();
      const first = new Promise((resolve) => { this.onShown = resolve; }), all = this.load();
      all.then(() => { if (foundry.source.live) this.later(); },
        (error) => fill(this.state, h("p", {class: "warning"}, `Not all runs are shown: ${error.message}`)));
      await Promise.race([first, all]);
      return this;
    }

    /** Change what is looked at: the address says it, and the page follows. */
    change(changes, push = true) {
      foundry.address.change(changes, {push});
      this.restore(foundry.address.read());
    }

    /** Sort the runs by a measure, which then is a column. */
    sortBy(measure) {
      const {shown} = this;
      this.change({...!shown.includes(measure) && {columns: [...shown, measure].join(",")}, sort: measure, page: null});
    }

    /** Show what the address asks for by now. */
    restore(query) {
      this.query = query;
      this.lookAsAsked();
      this.drawControls();
      return this.loadMeasures();
    }

    asked(key) { return this.query.get(key) || ""; }

    list(key) { return this.asked(key).split(",").filter(Boolean); }

    /** The measures that somebody asked for as columns; null where nobody did. */
    get chosen() { return this.query.has("columns") ? this.list("columns").filter((one) => this.head.measures.includes(one)) : null; }

    /** The measures that are columns: without a choice those that claims rest on, as far as the runs of these worlds have them. */
    get shown() {
      const rows = this.asked("world") || this.asked("group") ? this.matching : this.rows;
      return this.chosen || this.head.claimed.filter((name) => rows.some((row) => this.value(name, row) !== null)).slice(0, MOST_SHOWN);
    }

    value(name, row) { return this.values.get(name)?.[row.index] ?? null; }

    lookAsAsked() {
      const picked = this.list("pick");
      this.table.picked = new Set(picked);
      this.table.look({
        filters: {text: this.asked("q"), ...Object.fromEntries(FILTERS.map((key) => [key, this.asked(key)]))},
        within: this.summary.within(this.asked("group")), sort: this.asked("sort"), page: Math.max(0, Math.floor(Number(this.asked("page"))) || 0),
      });
      this.picked(picked);
      if (foundry.source.live) this.find.show({kind: this.asked("in") || "every", words: this.asked("find"), model: this.asked("model"), world: this.asked("world")});
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
      const before = this.head;
      this.head = await foundry.source.json(`sweep/${this.sweep.id}`);
      if (this.isNews("notes", this.head.notes) && (before || this.head.notes)) await this.loadNotes();
      if (this.isNews("links", this.head.links)) this.drawLinks();
      if (!before || this.isOpen() || inOrder(this.counted()) !== inOrder(this.head.counts)) await this.loadRows();
      if (this.disposed) return;
      if (this.isNews("controls", [this.head.measures, FILTERS.map((key) => this.choices(key))])) this.drawControls();
      await this.loadMeasures();
    }

    async loadRows() {
      const rows = [];
      for (let page = 0; rows.length < this.head.runs; page += 1) {
        rows.push(...(await foundry.source.json(`sweep/${this.sweep.id}/rows/${page}`)).rows);
        if (this.disposed) return;
        if (!this.rows) await this.showFirst([...rows]);
      }
      this.show(rows);
    }

    async loadNotes() {
      await this.noted.load();
      if (this.rows) this.show(this.rows);
    }

    /** Show the first runs, and their measures, before all others are there. */
    async showFirst(rows) {
      this.show(rows);
      this.onShown();
      this.drawControls();
      await this.loadMeasures();
    }

    show(rows) {
      rows.forEach((row, index) => {
        row.index = index;
        row.text = [row.run, row.model, row.prompt, row.world, row.form, row.seed, row.status, row.error || "", ...row.factors, ...this.noted.tell(row)].join(" ").toLocaleLowerCase();
      });
      this.rows = rows;
      this.drawState();
      if (this.isNews("failures", rows.map((row) => row.error))) this.drawFailures();
      if (this.isNews("unread", rows.map((row) => row.undecided))) this.drawUnread();
      if (!this.table.columns.length) this.table.columns = this.columns();
      if (this.isNews("rows", rows)) this.table.setRows(rows);
    }

    /** Return whether something is not as it was: what is as it was is not drawn again, so that nobody loses their place. */
    isNews(name, content) {
      const text = JSON.stringify(content), before = this.seen.get(name);
      this.seen.set(name, text);
      return text !== before;
    }

    async loadMeasures() {
      for (const name of new Set([...this.chosen || [], ...this.head.claimed])) {
        const index = this.head.measures.indexOf(name);
        if (index >= 0 && !this.values.has(name)) {
          this.values.set(name, (await foundry.source.json(`sweep/${this.sweep.id}/measure/${index}`)).values);
        }
      }
      if (this.isNews("groups", [this.head.claimed, this.head.links])) {
        await this.summary.load(this.sweep.id);
        this.lookAsAsked();
      }
      if (this.isNews("summary", [this.head.claimed, this.head.links, this.asked("group"), this.asked("world")])) this.drawSummary();
      const columns = this.columns();
      if (this.isNews("columns", [columns.map((one) => one.key), this.head.measures])) {
        this.table.setColumns(columns);
        this.drawControls();
      }
    }

    drawSummary() { this.summary.draw(this.head.claimed, this.values, this.head.models, {group: this.asked("group"), world: this.asked("world")}); }

    /** The columns of the table; the run's own cell says its model, its world and its seed. */
    columns() {
      const prompts = new Set(this.rows.map((row) => JSON.stringify([row.world, row.prompt]))).size > this.choices("world").length;
      const status = this.rows.some((row) => row.status !== "complete") ? [foundry.RunTable.plain("status")] : [];
      return [foundry.RunTable.plain("run"), ...status, ...this.noted.columns(), ...prompts ? [foundry.RunTable.plain("prompt")] : [], foundry.RunTable.plain("seed"), ...this.numbers()];
    }

    /** The columns of a file, in which no cell is left out for being the same in all rows. */
    saved() {
      const names = ["run", "status", "model", "prompt", "world", "form", "seed"];
      return [...names.map((key) => foundry.RunTable.plain(key)), ...this.numbers(), ...this.noted.saved()];
    }

    numbers() {
      return [
        ...this.head.factors.map((name, index) => ({key: name, label: name, value: (row) => row.factors[index]})),
        ...this.shown.map((name) => ({key: name, label: name, value: (row) => this.value(name, row)})),
        ...["undecided", "calls", "seconds"].map((key) => foundry.RunTable.plain(key)),
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
      const same = ["model", "world", "prompt"].filter((key) => this.choices(key).length === 1).map((key) => `${key} ${this.rows[0][key]}`);
      fill(this.state, h("progress", {max: String(runs), value: String(ended), "aria-label": "Runs that have ended"}),
        h("span", {}, `${ended} of ${runs} runs ended `), same.length ? h("span", {class: "note"}, `All: ${same.join(", ")}`) : null, this.rows.length < runs ? h("span", {}, `(${this.rows.length} looked at so far) `) : null, Object.entries(counts).map(([word, count]) => [badge(word), ` ${count} `]),
        foundry.source.live && this.isOpen() ? h("a", {href: `#/live/${this.sweep.id}`}, "what it is doing") : null);
    }

    drawFailures() {
      const causes = foundry.dom.grouped(this.rows.filter((row) => row.error), (row) => row.error);
      fill(this.failures, causes.size ? h("details", {class: "failures", open: true}, h("summary", {}, `Why runs failed (${[...causes.values()].flat().length})`),
        h("ul", {}, [...causes].slice(0, 20).map(([cause, rows]) => h("li", {}, h("b", {}, `${rows.length} × `), h("bdi", {}, cause), " ",
          rows.slice(0, 5).map((row) => [h("a", {href: `#/run/${this.sweep.id}/${row.run}`}, row.run), " "]), rows.length > 5 ? "…" : null)))) : null);
    }

    /** Tell of each model how many replies could not be read, and lead to them. */
    drawUnread() {
      const sum = (rows, key) => rows.reduce((total, row) => total + (row[key] || 0), 0);
      const models = [...foundry.dom.grouped(this.rows, (row) => row.model)].map(([model, rows]) => [model, sum(rows, "undecided"), sum(rows, "decisions")]);
      const told = ([model, undecided, decisions]) => h("li", {}, h("button", {type: "button", class: "go", disabled: !foundry.source.live,
        onclick: () => this.change({in: "unreadable", find: null, model, page: null})}, `${model}: ${undecided.toLocaleString("en")} of ${decisions.toLocaleString("en")} decisions were not readable`));
      const having = models.filter(([, undecided]) => undecided).sort((a, b) => b[1] / b[2] - a[1] / a[2]);
      fill(this.unread, having.length ? h("ul", {"aria-label": "Decisions that were not readable"}, having.map(told)) : null);
    }

    drawLinks() {
      const link = (one) => h("a", {href: foundry.source.file(this.sweep.id, one.path), target: "_blank", rel: "noopener"}, one.path);
      const reports = this.head.links.filter((one) => one.kind === "html"), others = this.head.links.filter((one) => one.kind !== "html");
      fill(this.links, reports.map((one) => h("span", {class: "report"}, link(one))),
        others.length ? h("details", {}, h("summary", {}, `plots and tables (${others.length})`), h("ul", {}, others.map((one) => h("li", {}, link(one))))) : null);
    }

    choices(key) { return [...new Set(this.rows.map((row) => row[key]))].sort(); }

    drawControls() {
      const select = (key) => h("select", {"aria-label": `Only this ${key}`, "data-filter": key, onchange: (event) => this.change({[key]: event.target.value, page: null})},
        h("option", {value: ""}, `every ${key}`), this.choices(key).map((value) => h("option", {value, selected: value === this.asked(key)}, value)));
      if (this.search.value !== this.asked("q")) this.search.value = this.asked("q");
      const group = this.asked("group");
      fill(this.choosing, group ? h("button", {type: "button", "aria-label": `Not only ${group}`, onclick: () => this.change({group: null, page: null})}, `${group} ✕`) : null,
        FILTERS.map(select), this.measureChoice(), this.compare,
        h("button", {type: "button", onclick: () => this.compareSeed()}, "Compare the models on a seed"), this.downloads());
    }

    /** What is shown, as a file; an exported page can make CSV alone. */
    downloads() {
      const save = (kind) => foundry.download[kind](this.sweep.id, this.saved(), this.matching, this.head.runs);
      return h("span", {class: "saving"}, ["csv", ...foundry.source.live ? ["parquet"] : []].map((kind) => h("button", {type: "button", "data-save": kind,
        title: "The runs and columns that are shown, as a file", onclick: () => save(kind)}, {csv: "CSV", parquet: "Parquet"}[kind])), this.noted.choice);
    }

    measureChoice() {
      if (!this.head.measures.length) return null;
      const {shown} = this;
      const list = h("div", {class: "menu-list"}, this.head.measures.map((name) => {
        const tick = h("input", {type: "checkbox", checked: shown.includes(name), onchange: () => this.change({
          columns: (tick.checked ? [...this.shown, name] : this.shown.filter((one) => one !== name)).join(",") || "none"})});
        return h("label", {}, tick, ` ${name}`);
      }));
      const before = this.choosing.querySelector(".menu");
      const menu = h("details", {class: "menu", open: Boolean(before?.open)}, h("summary", {}, "columns"), list);
      const top = before?.querySelector(".menu-list").scrollTop;
      requestAnimationFrame(() => { list.scrollTop = top || 0; });
      return menu;
    }

    /** Return what a run is called; its id as long as its row has not come. */
    nameOf(run) {
      const row = this.rows?.find((one) => one.run === run);
      return row ? foundry.RunTable.nameOf(row) : run;
    }

    tick(run) {
      const {picked} = this.table;
      if (!picked.delete(run)) picked.add(run);
      this.change({pick: [...picked].join(",")}, false);
    }

    picked(runs) {
      this.compare.hidden = runs.length < 2;
      this.compare.textContent = `Compare ${runs.length} runs`;
      this.compare.href = `#/compare/${this.sweep.id}/${runs.join("/")}`;
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
      if (best) location.hash = `#/compare/${this.sweep.id}/${best.map((row) => row.run).join("/")}`;
      else foundry.dom.announce("No seed was run with two models.");
    }
  }

  foundry.Overview = Overview;
  foundry.sweepChoice = sweepChoice;
})(window.Foundry);
