"use strict";
/* The page of a sweep: its progress, its runs, the causes of failures, and the files of the analysis. */
(function (foundry) {
  const {h, fill, badge} = foundry.dom;
  const POLL_MS = 1500;
  const IDLE_MS = 5000;
  const FILTERS = ["status", "model", "prompt", "world"];
  const MOST_SHOWN = 3;
  const NARROWING = ["in", "outcome", "agent", "from", "to"];
  const OPEN = ["running", "unfinished", "waiting"];
  const KEYS = [["/", "filter and search"], ...foundry.source.live ? [["N", "the notes of the run that has the keyboard focus"]] : []];

  /** Return the number of runs by status as a text, in a fixed order. */
  function inOrder(counts) { return JSON.stringify(Object.entries(counts).sort()); }

  /** Return a link to the other sweeps, or null if there are none. */
  function sweepChoice(sweeps, sweep) {
    const label = ({name, runs, when, working}) => [`${name} (${runs} runs)`, when ? when.slice(0, 10) : "", working ? "running" : ""].filter(Boolean).join(" · ");
    const choice = h("select", {"aria-label": "Sweep", onchange: () => { location.hash = `#/sweep/${choice.value}`; }},
      sweeps.map((choice) => h("option", {value: choice.id, selected: choice.id === sweep.id}, label(choice))));
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
      this.find = new foundry.Find(sweep.id, {
        onChange: (changes, push) => this.change(changes, push), onFound: () => this.lookAsAsked(), nameOf: (run) => this.nameOf(run)});
      this.noted = new foundry.Noted(sweep.id, {onChange: () => this.loadNotes(), onTag: (tag) => this.change({q: `tag:${tag}`, page: null})});
      const onUnread = (row) => this.change({row, in: "unreadable", find: null, q: null, page: null});
      this.matrix = new foundry.Matrix({onUnread, onSort: (measure) => this.sortBy(measure), onOpen: (open) => this.change({open}), onPick: (picked) => this.pick(picked)});
      this.lookAt = new foundry.LookAt(sweep.id, onUnread, (run) => this.nameOf(run));
      this.gallery = new foundry.Gallery(sweep.id);
      this.choosing = new foundry.Columns((names) => this.change({columns: names.join(",") || "none"}));
      this.table = new foundry.RunTable(sweep.id, {
        onTick: (run) => this.tick(run), onChange: (changes) => this.change(changes), onDraw: (rows) => { this.matching = rows; }});
      this.state = h("div", {class: "progress"});
      this.compare = h("a", {class: "button", hidden: true}, "Compare");
      this.saving = h("span", {class: "saving"});
      this.controls = h("div", {class: "controls"}, this.compare, h("button", {type: "button", onclick: () => this.compareSeed()}, "Compare the models on a seed"),
        this.choosing.element, this.saving, foundry.dom.keys(KEYS));
      this.onKeyDown = (event) => this.key(event);
      document.addEventListener("keydown", this.onKeyDown);
      this.element = h("div", {class: "overview"}, this.heading(),
        unreadable.map((why) => h("p", {class: "warning"}, `Not shown: ${why}`)),
        this.noted.unread, h("div", {class: "found-first"}, this.matrix.element, this.lookAt.element), this.gallery.element, this.find.element, this.controls, this.table.element, this.table.pager, this.noted.element);
    }

    dispose() {
      this.disposed = true;
      this.find.dispose();
      document.removeEventListener("keydown", this.onKeyDown);
    }

    key(event) {
      const run = event.target.closest("tr[data-run]")?.dataset.run;
      if (foundry.dom.isTyping(event)) return;
      if (event.key === "/") this.find.words.focus();
      else if (event.key === "n" && run && foundry.source.live) this.noted.open(run);
      else return;
      event.preventDefault();
    }

    heading() {
      this.history = h("details", {class: "asked"});
      return h("header", {class: "heading"}, h("h1", {}, this.sweep.name), sweepChoice(this.sweeps, this.sweep), this.state, this.gallery.reports, this.history);
    }

    drawHistory() {
      const {history} = this.head, code = (entry) => h("code", {}, `foundry ${entry.overrides.join(" ")}`);
      fill(this.history, h("summary", {}, history.length > 1 ? `${history.length} commands` : "command"), history.length > 1
        ? h("ol", {}, history.map((entry) => h("li", {}, code(entry), ` ${entry.runs} runs${entry.when ? `, ${entry.when.slice(0, 16).replace("T", " ")} UTC` : ""}`))) : history.map(code));
    }

    /** Show only the runs of a cell. If the cell belongs to a measure, sort the runs by this measure. */
    pick({row = null, world = null, measure = ""}) {
      this.change({row, world, page: null, ...measure && this.sorting(measure)});
    }

    /** Show the page when the first runs are loaded. The other runs are loaded later. */
    async open() {
      this.lookAsAsked();
      const first = new Promise((resolve) => { this.onShown = resolve; }), all = this.load();
      all.then(() => { if (foundry.source.live) this.later(); },
        (error) => fill(this.state, h("p", {class: "warning"}, `Not all runs are shown: ${error.message}`)));
      await Promise.race([first, all]);
      return this;
    }

    /** Change the view by changing the address; the page then shows what the address describes. */
    change(changes, push = true) {
      foundry.address.change(changes, {push});
      this.restore(foundry.address.read());
    }

    /** Return the address of the view in which the runs are sorted by a measure, and this measure is a column. */
    sorting(measure) {
      const {shown} = this;
      return {...!shown.includes(measure) && {columns: [...shown, measure].join(",")}, sort: measure, page: null};
    }

    sortBy(measure) { this.change(this.sorting(measure)); }

    /** Show the view that the address describes. */
    restore(query) {
      this.query = query;
      this.lookAsAsked();
      this.drawControls();
      return this.loadMeasures();
    }

    asked(key) { return this.query.get(key) || ""; }

    list(key) { return this.asked(key).split(",").filter(Boolean); }

    /** The measures that the user chose as columns; null without a choice. */
    get chosen() { return this.query.has("columns") ? this.list("columns").filter((name) => this.head.measures.includes(name)) : null; }

    /**
     * The measures that are columns. Without a choice, these are the measures that claims rest on, if the runs of these
     * worlds have them.
     */
    get shown() {
      const rows = this.asked("world") || this.asked("row") ? this.matching : this.rows;
      return this.chosen || this.head.claimed.filter((name) => rows.some((row) => this.value(name, row) !== null)).slice(0, MOST_SHOWN);
    }

    value(name, row) { return this.values.get(name)?.[row.index] ?? null; }

    lookAsAsked() {
      const picked = this.list("pick");
      this.table.picked = new Set(picked);
      this.table.look({
        filters: {text: this.asked("q"), ...Object.fromEntries(FILTERS.map((key) => [key, this.asked(key)]))},
        within: (row) => this.isAsked(row), sort: this.asked("sort"), page: Math.max(0, Math.floor(Number(this.asked("page"))) || 0),
      });
      this.picked(picked);
      this.find.restore(this.query);
      if (this.rows && this.rows.length === this.head.runs) this.find.show(this.query, this.searched());
    }

    /**
     * Return whether a run belongs to the chosen row, and has search results or, in a search without further conditions,
     * contains the words.
     */
    isAsked(row) {
      const words = this.find.inRuns ? this.asked("find").toLocaleLowerCase().split(/\s+/).filter(Boolean) : [];
      const hit = !this.find.inRuns || row.run in this.find.inRuns || (words.length > 0 && !NARROWING.some((key) => this.asked(key)) && words.every((word) => row.text.includes(word)));
      return hit && (!this.asked("row") || row.row === this.asked("row"));
    }

    /** Return the searched runs as a mask; empty for all. */
    searched() {
      const wanted = [...FILTERS, "row"].filter((key) => this.asked(key));
      if (!wanted.length) return "";
      return foundry.download.mask(this.rows.filter((row) => wanted.every((key) => String(row[key]) === this.asked(key))), this.head.runs);
    }

    /** Load the data again from time to time, because runs go on, and an analysis or a report may follow. */
    later() {
      if (this.disposed) return;
      setTimeout(async () => {
        if (this.disposed) return;
        try {
          await this.load();
        } catch (error) {
          if (!this.isOpen()) return;
          fill(this.state, h("p", {class: "warning"}, `The server does not answer: ${error.message}`));
        }
        this.later();
      }, this.isOpen() ? POLL_MS : IDLE_MS);
    }

    isOpen() { return this.rows.some((row) => OPEN.includes(row.status)); }

    async load() {
      const before = this.head;
      this.head = await foundry.source.json(`sweep/${this.sweep.id}`);
      if (this.isNews("notes", this.head.notes) && (before || this.head.notes)) await this.loadNotes();
      if (this.isNews("links", this.head.links)) this.gallery.draw(this.head.links);
      if (this.isNews("history", this.head.history)) this.drawHistory();
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

    /** Show the first runs and their measures before all others are loaded. */
    async showFirst(rows) {
      this.show(rows);
      this.onShown();
      this.drawControls();
      await this.loadMeasures();
    }

    show(rows) {
      rows.forEach((row, index) => {
        row.index = index;
        row.text = [row.run, foundry.RunTable.nameOf(row), row.model, row.prompt, row.world, row.form, row.seed, row.status, row.error || "", ...row.factors, ...this.noted.tell(row)].join(" ").toLocaleLowerCase();
      });
      this.rows = rows;
      this.drawState();
      this.matrix.arrange(rows);
      if (!this.table.columns.length) this.table.columns = this.columns();
      if (this.isNews("rows", rows)) {
        this.table.setRows(rows);
        this.seen.delete("looked");
      }
    }

    /**
     * Return whether something has changed. Unchanged parts are not drawn again, so that the focus and the scroll
     * position stay.
     */
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
        await this.matrix.load(this.sweep.id);
        this.matrix.arrange(this.rows);
      }
      const looked = ["row", "world", "open", "sort"].map((key) => this.asked(key));
      if (this.isNews("found", [this.head.claimed, this.head.links, looked, this.rows.map((row) => [row.status, row.calls])])) this.drawFound();
      if (this.isNews("looked", [`${this.query}`, [...this.values.keys()]])) this.lookAsAsked();
      const columns = this.columns();
      if (this.isNews("columns", [columns.map((column) => column.key), this.head.measures])) {
        this.table.setColumns(columns);
        this.drawControls();
      }
    }

    /** The columns of the table. The first cell shows the model, the world and the seed of the run. */
    columns() {
      const prompts = new Set(this.rows.map((row) => JSON.stringify([row.world, row.prompt]))).size > this.choices("world").length;
      const status = this.rows.some((row) => row.status !== "complete") ? [foundry.RunTable.plain("status")] : [];
      return [foundry.RunTable.plain("run"), ...status, ...this.noted.columns(), ...prompts ? [foundry.RunTable.plain("prompt")] : [], foundry.RunTable.plain("seed"), ...this.numbers()];
    }

    /** The columns of a saved file. It keeps columns that are equal in all rows. */
    saved() {
      const names = ["run", "status", "model", "prompt", "world", "form", "seed"];
      return [...names.map((key) => foundry.RunTable.plain(key)), ...this.numbers(), ...this.noted.saved()];
    }

    numbers() {
      return [
        ...this.head.factors.map((name, index) => ({key: name, label: name, value: (row) => row.factors[index]})),
        ...this.shown.map((name) => ({key: name, label: name, value: (row) => this.value(name, row)})),
        ...["undecided", "messages", "calls", "tokens", "seconds"].map((key) => foundry.RunTable.plain(key)),
      ];
    }

    /** Return the number of loaded rows by status. */
    counted() {
      const counts = {};
      this.rows.forEach((row) => { counts[row.status] = (counts[row.status] || 0) + 1; });
      return counts;
    }

    drawState() {
      const {runs} = this.head, counts = this.counted(), ended = (counts.complete || 0) + (counts.failed || 0);
      const sides = ["model", "world", "prompt", "seed"].map((key) => [key, this.choices(key)]);
      const text = sides.map(([key, values]) => (values.length === 1 ? `${key} ${values[0]}` : `${values.length} ${key}s`)).join(" · ");
      fill(this.state, h("span", {class: "note"}, text), ended < runs ? h("progress", {max: String(runs), value: String(ended), "aria-label": "Runs that have ended"}) : null,
        h("span", {}, `${ended} of ${runs} runs ended `), this.rows.length < runs ? h("span", {}, `(${this.rows.length} read so far) `) : null, Object.entries(counts).map(([word, count]) => [badge(word), count === runs ? " " : ` ${count} `]),
        foundry.source.live && this.isOpen() ? h("a", {href: `#/live/${this.sweep.id}`}, "live progress") : null);
    }

    drawFound() {
      const {row, world, open, sort} = Object.fromEntries(["row", "world", "open", "sort"].map((key) => [key, this.asked(key)]));
      this.matrix.draw(this.rows, this.head.models, this.head.claimed, this.values, {row, world, open, sort: sort.replace("-", "")});
      this.lookAt.draw(this.rows, this.matrix.summary, this.matrix.rows);
    }

    choices(key) { return [...new Set(this.rows.map((row) => row[key]))].sort(); }

    drawControls() {
      const select = (key) => h("select", {"aria-label": `Only this ${key}`, "data-filter": key, onchange: (event) => this.change({[key]: event.target.value, page: null})},
        h("option", {value: ""}, `every ${key}`), this.choices(key).map((value) => h("option", {value, selected: value === this.asked(key)}, value)));
      const row = this.asked("row");
      fill(this.find.filters, row ? h("button", {type: "button", "aria-label": `Not only ${row}`, onclick: () => this.change({row: null, page: null})}, `${row} ✕`) : null,
        FILTERS.filter((key) => this.choices(key).length > 1 || this.asked(key)).map(select));
      this.choosing.set(this.head.measures, this.shown);
      fill(this.saving, this.downloads());
    }

    /** Save the visible rows and columns as a file. */
    downloads() {
      return [h("button", {type: "button", "data-save": "csv", title: "The runs and columns that are shown, as a file",
        onclick: () => foundry.download.csv(this.sweep.id, this.saved(), this.matching)}, "CSV"), this.noted.choice];
    }

    /** Return the name of a run, or its id until its row is loaded. */
    nameOf(run) {
      const row = this.rows?.find((row) => row.run === run);
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

    /** Go to the first seed, among the visible runs, that several models played with the same prompt. */
    compareSeed() {
      const groups = new Map();
      for (const row of this.table.matching().filter((row) => row.status !== "waiting")) {
        const key = JSON.stringify([row.seed, row.prompt, row.world]);
        const group = groups.get(key) || [];
        if (!group.some((other) => other.model === row.model)) groups.set(key, [...group, row]);
      }
      const best = [...groups.values()].find((group) => group.length > 1);
      if (best) location.hash = `#/compare/${this.sweep.id}/${best.map((row) => row.run).join("/")}`;
      else foundry.dom.announce("No seed has runs of two models.");
    }
  }

  foundry.Overview = Overview;
  foundry.sweepChoice = sweepChoice;
})(window.Foundry);
