"use strict";
/* The table of a sweep's runs. It sorts and filters the runs in the browser, and draws one page at a time. */
(function (foundry) {
  const {h, fill, badge, number, breakable} = foundry.dom;
  const ROWS = 100;

  function compareValues(a, b) {
    if (a === b) return 0;
    if (a === null || a === undefined) return 1;
    if (b === null || b === undefined) return -1;
    return typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(String(b), "en", {numeric: true});
  }

  /** Return whether the texts of a run contain a word, or its notes a tag: `tag:odd`, or `tag:` for any tag. */
  function says(row, word) {
    if (!word.startsWith("tag:")) return row.text.includes(word);
    return word === "tag:" ? row.tags.size > 0 : row.tags.has(word.slice("tag:".length));
  }

  class RunTable {
    /**
     * @param sweep the sweep's id
     * @param options.onTick called with a run that the user adds to the comparison or removes from it
     * @param options.onChange called with the order and the page for the address
     * @param options.onDraw called with the matching rows each time they are drawn
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
      this.filters = {text: ""};
      this.within = () => true;
      this.head = h("tr");
      this.body = h("tbody");
      this.pager = h("div", {class: "pager"});
      this.element = h("div", {class: "table-box", tabindex: "0", role: "region", "aria-label": "Runs"},
        h("table", {class: "runs"}, h("caption", {class: "unseen"}, "Runs of the sweep"), h("thead", {}, this.head), this.body));
    }

    /** Return the column of a key of the rows. */
    static plain(key) { return {key, label: key, value: (row) => row[key]}; }

    /** Return the name of a run. */
    static nameOf(row) { return `${row.model} · ${row.world} · seed ${row.seed}`; }

    setColumns(columns) { this.columns = columns; this.draw(); }
    setRows(rows) { this.rows = rows; this.draw(); }

    /**
     * Show only the rows with these words and values, in this order.
     * @param filters.text words; all other filters are values by the key of a row, or "" for any value
     * @param within returns whether other conditions allow a row
     */
    look({filters, within, sort, page}) {
      Object.assign(this, {filters, within, page});
      this.down = sort.startsWith("-");
      this.sortBy = sort.replace(/^-/, "") || null;
      this.draw();
    }

    sort(key) {
      const down = this.sortBy === key && !this.down;
      this.options.onChange({sort: `${down ? "-" : ""}${key}`, page: null});
    }

    matching() {
      const {text, ...values} = this.filters, words = text.toLocaleLowerCase().split(/\s+/).filter(Boolean);
      const wanted = Object.entries(values).filter(([, value]) => value !== "");
      const rows = this.rows.filter((row) => wanted.every(([key, value]) => String(row[key]) === value)
        && words.every((word) => says(row, word)) && this.within(row));
      const column = this.columns.find((column) => column.key === this.sortBy);
      if (!column) return rows;
      const sign = this.down ? -1 : 1;
      return [...rows].sort((a, b) => {
        const [x, y] = [column.value(a), column.value(b)];
        const missing = (value) => value === null || value === undefined;
        return missing(x) || missing(y) ? compareValues(x, y) : sign * compareValues(x, y);
      });
    }

    draw() {
      const rows = this.matching(), pages = Math.max(1, Math.ceil(rows.length / ROWS));
      const page = this.at = Math.min(this.page, pages - 1);
      fill(this.head, h("th", {scope: "col"}, h("span", {class: "unseen"}, "Compare")), this.columns.map((column) => this.header(column)));
      fill(this.body, rows.slice(page * ROWS, (page + 1) * ROWS).map((row) => this.row(row)));
      fill(this.pager, h("span", {role: "status", class: "shown"}, `${rows.length} of ${this.rows.length} runs`),
        pages > 1 ? [this.pageButton("◀", "Previous page", -1, page > 0), ` page ${page + 1} of ${pages} `, this.pageButton("▶", "Next page", 1, page < pages - 1)] : null);
      this.options.onDraw(rows);
    }

    /** Show another page of rows, from its top. */
    turn(by) {
      this.options.onChange({page: this.at + by || null});
      this.element.scrollTop = 0;
      this.element.scrollIntoView({block: "nearest"});
    }

    pageButton(sign, label, by, possible) {
      return h("button", {type: "button", "aria-label": label, disabled: !possible, onclick: () => this.turn(by)}, sign);
    }

    header(column) {
      const sorted = this.sortBy === column.key ? (this.down ? "descending" : "ascending") : "none";
      const numbers = !column.cell && this.rows.some((row) => typeof column.value(row) === "number");
      return h("th", {scope: "col", "aria-sort": sorted, class: numbers ? "number" : null},
        h("button", {type: "button", "data-sort": column.key, onclick: () => this.sort(column.key)},
        breakable(column.label), h("span", {"aria-hidden": "true"}, {ascending: " ▲", descending: " ▼", none: ""}[sorted])));
    }

    row(row) {
      const tick = h("input", {type: "checkbox", "aria-label": `Compare ${row.run}`, checked: this.picked.has(row.run), onchange: () => this.options.onTick(row.run)});
      return h("tr", {"data-run": row.run}, h("td", {}, tick), this.columns.map((column) => this.cell(column, row)));
    }

    cell(column, row) {
      if (column.cell) return h("td", {}, column.cell(row));
      const value = column.value(row);
      if (column.key === "run") return h("th", {scope: "row"}, h("a", {href: `#/run/${this.sweep}/${row.run}`, title: row.run}, RunTable.nameOf(row)));
      if (column.key === "status") {
        const progress = row.done !== null && row.planned ? ` ${row.done}/${row.planned}` : "";
        return h("td", {}, row.status === "complete" ? null : badge(row.status), progress, row.error ? h("span", {class: "cause", title: row.error}, ` ${row.error}`) : null);
      }
      return h("td", {class: typeof value === "number" || value === null ? "number" : null}, typeof value === "number" || value === null ? number(value) : value);
    }
  }

  foundry.RunTable = RunTable;
})(window.Foundry);
