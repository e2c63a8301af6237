"use strict";
/* The table of a sweep's runs: sorted and filtered here, drawn a page at a time. */
(function (foundry) {
  const {h, fill, badge, number} = foundry.dom;
  const ROWS = 100;

  function compareValues(a, b) {
    if (a === b) return 0;
    if (a === null || a === undefined) return 1;
    if (b === null || b === undefined) return -1;
    return typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(String(b), "en", {numeric: true});
  }

  /** Return a dotted name that may be broken behind its dots. */
  function breakable(name) { return name.split(/(?<=\.)/).map((part, index) => [index ? h("wbr") : null, part]); }

  class RunTable {
    /**
     * @param sweep the sweep's id
     * @param options.onPick called when the runs that are picked for comparison change
     */
    constructor(sweep, options) {
      this.sweep = sweep;
      this.options = options;
      this.rows = [];
      this.columns = [];
      this.sortBy = null;
      this.down = false;
      this.page = 0;
      this.picked = new Set();
      this.filters = {text: "", status: "", model: "", prompt: ""};
      this.head = h("tr");
      this.body = h("tbody");
      this.pager = h("div", {class: "pager"});
      this.element = h("div", {class: "table-box", tabindex: "0", role: "region", "aria-label": "Runs"},
        h("table", {class: "runs"}, h("caption", {class: "unseen"}, "Runs of the sweep"), h("thead", {}, this.head), this.body));
    }

    setColumns(columns) { this.columns = columns; this.draw(); }
    setRows(rows) { this.rows = rows; this.draw(); }
    filter(changes) { Object.assign(this.filters, changes); this.page = 0; this.draw(); }

    sort(key) {
      this.down = this.sortBy === key ? !this.down : false;
      this.sortBy = key;
      this.draw();
    }

    matching() {
      const {text, status, model, prompt} = this.filters, words = text.toLocaleLowerCase().split(/\s+/).filter(Boolean);
      const rows = this.rows.filter((row) => (!status || row.status === status) && (!model || row.model === model) && (!prompt || row.prompt === prompt)
        && words.every((word) => row.text.includes(word)));
      const column = this.columns.find((one) => one.key === this.sortBy);
      if (!column) return rows;
      const sign = this.down ? -1 : 1;
      return [...rows].sort((a, b) => {
        const [x, y] = [column.value(a), column.value(b)];
        const missing = (one) => one === null || one === undefined;
        return missing(x) || missing(y) ? compareValues(x, y) : sign * compareValues(x, y);
      });
    }

    draw() {
      const rows = this.matching(), pages = Math.max(1, Math.ceil(rows.length / ROWS));
      this.page = Math.min(this.page, pages - 1);
      fill(this.head, h("th", {scope: "col"}, h("span", {class: "unseen"}, "Compare")), this.columns.map((column) => this.header(column)));
      fill(this.body, rows.slice(this.page * ROWS, (this.page + 1) * ROWS).map((row) => this.row(row)));
      fill(this.pager, h("span", {role: "status", class: "shown"}, `${rows.length} of ${this.rows.length} runs`),
        pages > 1 ? [this.pageButton("◀", "Previous page", -1, this.page > 0), ` page ${this.page + 1} of ${pages} `, this.pageButton("▶", "Next page", 1, this.page < pages - 1)] : null);
    }

    pageButton(sign, label, by, possible) {
      return h("button", {type: "button", "aria-label": label, disabled: !possible, onclick: () => { this.page += by; this.draw(); }}, sign);
    }

    header(column) {
      const sorted = this.sortBy === column.key ? (this.down ? "descending" : "ascending") : "none";
      const numbers = this.rows.some((row) => typeof column.value(row) === "number");
      return h("th", {scope: "col", "aria-sort": sorted, class: numbers ? "number" : null},
        h("button", {type: "button", "data-sort": column.key, onclick: () => this.sort(column.key)},
        breakable(column.label), h("span", {"aria-hidden": "true"}, {ascending: " ▲", descending: " ▼", none: ""}[sorted])));
    }

    row(row) {
      const tick = h("input", {type: "checkbox", "aria-label": `Compare ${row.run}`, checked: this.picked.has(row.run), onchange: () => {
        if (tick.checked) this.picked.add(row.run); else this.picked.delete(row.run);
        this.options.onPick([...this.picked]);
      }});
      return h("tr", {"data-run": row.run}, h("td", {}, tick), this.columns.map((column) => this.cell(column, row)));
    }

    cell(column, row) {
      const value = column.value(row);
      if (column.key === "run") return h("th", {scope: "row"}, h("a", {href: `#/run/${this.sweep}/${row.run}`}, row.run));
      if (column.key === "status") {
        const progress = row.done !== null && row.planned ? ` ${row.done}/${row.planned}` : "";
        return h("td", {}, badge(row.status), progress, row.error ? h("span", {class: "cause", title: row.error}, ` ${row.error}`) : null);
      }
      return h("td", {class: typeof value === "number" || value === null ? "number" : null}, typeof value === "number" || value === null ? number(value) : value);
    }
  }

  foundry.RunTable = RunTable;
})(window.Foundry);
