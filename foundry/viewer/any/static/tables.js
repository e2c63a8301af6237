"use strict";
/* Shows the lines of a step as tables: decisions with the world's own keys, and the world's own record files. */
(function (foundry) {
  const {h, fill, badge, number} = foundry.dom;
  const COMMON = ["step", "agent", "kind", "action", "outcome", "utility", "message"];
  const ROWS = 100;
  const LONG = 24;

  /** Return a value of a record as the content of a cell. */
  function cell(value) {
    if (value === null || value === undefined) return h("td", {class: "nothing"}, "–");
    if (typeof value === "number") return h("td", {class: "number"}, number(value, 6));
    if (typeof value === "boolean") return h("td", {}, value ? "yes" : "no");
    const text = typeof value === "string" ? value : JSON.stringify(value);
    return h("td", {class: text.length > LONG ? "text" : null}, h("bdi", {}, text));
  }

  /** Return all keys of some lines, the declared keys first, without the keys in `without`. */
  function keysOf(rows, declared, without = []) {
    return [...new Set([...declared, ...rows.flatMap((row) => Object.keys(row))])].filter((key) => !without.includes(key));
  }

  /** A table that shows a page of rows at a time. */
  class Paged {
    constructor(label) {
      this.page = 0;
      this.head = h("thead");
      this.body = h("tbody");
      this.pager = h("div", {class: "pager", hidden: true});
      this.element = h("div", {}, h("div", {class: "table-box", tabindex: "0", role: "region", "aria-label": label},
        h("table", {class: "runs lines"}, h("caption", {class: "unseen"}, label), this.head, this.body)), this.pager);
    }

    /** @param make(row) returns the cells of a row
        @param chosen index of the row whose page is shown, or -1 */
    show(columns, rows, make, chosen = -1) {
      const pages = Math.max(1, Math.ceil(rows.length / ROWS));
      if (chosen >= 0) this.page = Math.floor(chosen / ROWS);
      this.page = Math.min(this.page, pages - 1);
      const turn = (sign, label, by) => h("button", {type: "button", "aria-label": label, disabled: this.page + by < 0 || this.page + by >= pages,
        onclick: () => { this.page += by; this.show(columns, rows, make); }}, sign);
      const isNumber = (name) => name !== "agent" && rows.some((row) => typeof row[name] === "number") && rows.every((row) => typeof (row[name] ?? 0) === "number");
      fill(this.head, h("tr", {}, columns.map((name) => h("th", {scope: "col", class: isNumber(name) ? "number" : null}, name))));
      fill(this.body, rows.slice(this.page * ROWS, (this.page + 1) * ROWS).map(make));
      this.pager.hidden = pages === 1;
      fill(this.pager, turn("◀", "Previous rows", -1), ` ${this.page * ROWS + 1} to ${Math.min(rows.length, (this.page + 1) * ROWS)} of ${rows.length} `, turn("▶", "Next rows", 1));
    }
  }

  /** The decisions of a step. */
  class StepTable {
    constructor(data, onSelect) {
      this.data = data;
      this.onSelect = onSelect;
      this.title = h("summary");
      this.table = new Paged("Decisions of the step");
      this.element = h("details", {class: "lines-box"}, this.title, this.table.element);
    }

    show(step, rows, selected) {
      const kinds = new Set(rows.map((row) => row.kind)).size > 1 || Object.keys(this.data.about.actions).length > 1;
      const has = (key) => rows.some((row) => row[key] !== null && row[key] !== undefined);
      const own = keysOf(rows, Object.keys(this.data.about.keys), COMMON);
      const columns = ["agent", ...(kinds ? ["kind"] : []), "action", "outcome", ...["utility", "message"].filter(has), ...own];
      fill(this.title, h("b", {}, `decisions of step ${step}`), h("small", {}, " with all recorded keys"));
      const make = (row) => h("tr", {"data-agent": String(row.agent), class: row.agent === selected ? "chosen" : null}, columns.map((key) => this.cell(row, key)));
      this.table.show(columns, rows, make, rows.findIndex((row) => row.agent === selected));
    }

    cell(row, key) {
      if (key === "agent") {
        const pick = h("button", {type: "button", class: "go", "aria-label": `Agent ${row.agent}`, onclick: () => this.onSelect(row.agent)}, String(row.agent));
        return h("th", {scope: "row"}, pick);
      }
      return key === "outcome" && row.outcome ? h("td", {}, badge(row.outcome)) : cell(row[key]);
    }
  }

  /** The lines of the world's other record files: those of the step, or the first lines if they have no step. */
  class StreamTables {
    constructor(data) {
      this.data = data;
      this.tables = data.about.streams.map((stream, index) => this.made(stream, index));
      this.element = h("div", {class: "streams"}, this.tables.map((table) => table.element));
    }

    made(stream, index) {
      const table = new Paged(`Lines of ${stream.name}`), count = h("small");
      const element = h("details", {class: "lines-box", open: true, hidden: true}, h("summary", {}, h("b", {}, stream.name), " ", count), table.element);
      return {stream, index, table, count, element};
    }

    async show(step) {
      this.step = step;
      const {data} = this, size = data.about.steps_per_chunk;
      for (const table of this.tables) {
        const rows = await this.rows(table, table.stream.by_step ? data.numberOf(step, size) : 0);
        if (this.step !== step) return;
        this.fill(table, table.stream.by_step ? rows.filter((row) => row.step === step) : rows);
      }
    }

    /** Return the lines of a chunk. The last chunk stays in memory unless the run grows. */
    async rows(table, chunk) {
      const key = `${chunk}/${this.data.done}/${this.data.progress.beginning}`;
      if (table.key !== key) table.rows = (await this.data.once(`stream/${table.index}/${chunk}`)).rows;
      table.key = key;
      return table.rows;
    }

    fill({stream, table, count, element}, rows) {
      const columns = keysOf(rows, stream.keys, stream.by_step ? ["step"] : []);
      element.hidden = !rows.length;
      count.textContent = stream.by_step ? `${rows.length} of this step` : rows.length === 1 ? "one line" : `${rows.length} lines`;
      table.show(columns, rows, (row) => h("tr", {}, columns.map((key) => cell(row[key]))));
    }
  }

  foundry.anyTables = {StepTable, StreamTables, keysOf, COMMON};
})(window.Foundry);
