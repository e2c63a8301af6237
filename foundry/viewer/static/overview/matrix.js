"use strict";
/* The table of models and worlds, as in the report, with the cost of the runs of each model. A click on a name opens its measures. */
(function (foundry) {
  const {h, s, fill, number, breakable} = foundry.dom, {marks, looks} = foundry;

  function sum(runs, key) { return runs.reduce((total, run) => total + (run[key] || 0), 0); }

  function duration(seconds) {
    if (seconds >= 3600) return `${(seconds / 3600).toFixed(1)} h`;
    return seconds >= 90 ? `${Math.round(seconds / 60)} min` : `${Math.round(seconds)} s`;
  }

  function short(count) {
    if (count >= 1e6) return `${(count / 1e6).toFixed(1)} M`;
    return count >= 10000 ? `${Math.round(count / 1000)} k` : count.toLocaleString("en");
  }

  /** Return a share in percent; the text is 100 only if the share is exactly 1. */
  function percent(part, all) {
    const share = 100 * part / all;
    return `${share === 100 ? "100" : Math.min(99.9, share).toFixed(1)} %`;
  }

  class Matrix {
    /**
     * @param onPick called with the row, world and measure of the cell that the user clicked; null for each that does not matter
     * @param onOpen called with the name of the row whose measures are shown, or null
     * @param onSort called with the measure whose column head the user clicked
     * @param onUnread called with the model whose unreadable replies the user wants to see
     */
    constructor(options) {
      this.options = options;
      this.summary = {columns: [], groups: [], group_of: [], part: "", findings: [], matrix: null, furthest: [], labels: {}};
      this.rows = [];
      this.element = h("section", {class: "matrix", "aria-label": "Models and worlds"});
    }

    async load(sweep) {
      this.summary = await foundry.source.json(`sweep/${sweep}/groups`);
    }

    /** Assign each run to the row of its group; without one, to the only row of its model; without one, to a new row. */
    arrange(runs) {
      const {columns, groups, group_of: groupOf, matrix} = this.summary, at = columns.indexOf("model"), places = new Map();
      this.rows = (matrix?.rows || []).map((row) => ({name: row.name, model: row.groups[0][at], cells: row.cells, groups: row.groups, runs: []}));
      this.rows.forEach((row) => row.groups.forEach((group) => places.set(JSON.stringify(group), row)));
      for (const run of runs) {
        const group = groups[groupOf[run.index]], known = group && places.get(JSON.stringify(group.values));
        const alike = known ? [known] : this.rows.filter((row) => row.model === run.model);
        const row = alike.length === 1 ? alike[0] : this.rows.find((row) => row.name === run.model) || this.begin(run.model);
        row.runs.push(run);
        run.row = row.name;
      }
    }

    begin(model) {
      const row = {name: model, model, cells: null, groups: [], runs: []};
      this.rows.push(row);
      return row;
    }

    /**
     * @param runs all rows that are loaded so far
     * @param models all models, in the order of their colours
     * @param asked.row the only visible row; asked.world the world; asked.open the row whose measures are shown
     */
    draw(runs, models, measures, values, asked) {
      this.looks = looks.ofModels(models);
      this.arrange(runs);
      const {matrix, part} = this.summary, worlds = [...new Set(runs.map((run) => run.world))];
      const columns = matrix?.columns.length ? matrix.columns : worlds.map((world) => ({title: world, label: "", measure: "", world}));
      const missing = matrix ? worlds.filter((world) => !columns.some((column) => column.world === world)) : [];
      const all = [...columns, ...missing.map((world) => ({title: world, label: "", measure: "", world}))];
      fill(this.element, part ? h("p", {class: "note"}, `Analysed: ${part}`) : null,
        h("div", {class: "table-box", tabindex: "0", role: "region", "aria-label": "Models and worlds, as a table"}, h("table", {class: "runs"},
          h("caption", {class: "note"}, matrix ? `${matrix.caption} Click a model to see its measures, or a cell to see its runs.` : "Runs that have ended. Analyse the sweep to see scores."),
          h("thead", {}, h("tr", {}, h("th", {scope: "col"}, "model"), all.map((column) => this.head(column)),
            ["readable replies", "calls", "tokens", "time"].map((text) => h("th", {scope: "col", class: "number"}, text)))),
          h("tbody", {}, this.rows.map((row) => this.row(row, all, asked))))),
        this.strips(this.rows.find((row) => row.name === asked.open), measures, values));
    }

    head({title, label, measure}) {
      const text = [title, measure && label && label !== title ? h("small", {}, label) : null, measure ? h("small", {}, breakable(measure)) : null];
      return h("th", {scope: "col"}, measure ? h("button", {type: "button", title: "Sort the runs by this measure", onclick: () => this.options.onSort(measure)}, text) : text);
    }

    marker(model) {
      const look = this.looks.get(model);
      return look ? looks.mark(look) : null;
    }

    row(row, columns, asked) {
      const opened = asked.open === row.name, {runs} = row, replies = sum(runs, "replies"), undecided = sum(runs, "undecided");
      const name = h("button", {type: "button", "aria-expanded": String(opened), title: "Measures of this row", onclick: () => this.options.onOpen(opened ? null : row.name)}, this.marker(row.model), " ", row.name);
      const readable = replies ? percent(replies - undecided, replies) : "not yet";
      const reaches = (row.cells || []).map((cell) => cell.reach), least = reaches.filter((reach) => reach !== null).length > 1 ? Math.min(...reaches.filter((reach) => reach !== null)) : null;
      return h("tr", {}, h("th", {scope: "row"}, name),
        columns.map((column, place) => this.cell(row, column, row.cells?.[place], {asked, least})),
        h("td", {class: "number"}, undecided && foundry.source.live ? h("button", {type: "button", class: "go", title: "List the replies that could not be read", onclick: () => this.options.onUnread(row.name)}, readable) : readable),
        [sum(runs, "calls").toLocaleString("en"), short(sum(runs, "tokens")), duration(sum(runs, "seconds"))].map((text) => h("td", {class: "number"}, text)));
    }

    cell(row, column, cell, {asked, least}) {
      const mine = row.runs.filter((run) => run.world === column.world), ended = mine.filter((run) => run.status === "complete" || run.status === "failed");
      if (!mine.length && !cell) return h("td", {class: "note"}, "no runs");
      const pressed = asked.row === row.name && (asked.world === column.world || (!asked.world && column.measure === asked.sort));
      const [mean, interval] = (cell?.text || "").split(" ["), wrapped = {greatest: "b", least: "u"}[cell?.end];
      const text = cell ? [wrapped ? h(wrapped, {}, mean) : mean, interval ? h("small", {}, `[${interval}`) : null] : `${ended.length} of ${mine.length} runs`;
      return h("td", {}, h("button", {type: "button", "aria-pressed": String(pressed), "aria-label": `Only ${row.name}, ${column.title}: ${cell?.text || text}`,
        onclick: () => this.options.onPick(pressed ? {} : {row: row.name, world: column.world, measure: column.measure})},
        text, cell && cell.reach !== null ? this.bar(cell.reach, row.model) : null,
        cell && cell.reach !== null && cell.reach === least ? h("small", {class: "worst"}, "▾ its worst world") : null,
        cell && ended.length < mine.length ? h("small", {}, `${ended.length} of ${mine.length} runs`) : null));
    }

    bar(reach, model) {
      return s("svg", {class: "bar", viewBox: "0 0 100 6", preserveAspectRatio: "none", "aria-hidden": "true"},
        s("rect", {width: 100, height: 6, fill: "currentColor", opacity: ".15"}), s("rect", {width: 100 * reach, height: 6, fill: this.looks.get(model)?.paint || looks.baseline}));
    }

    /** The measures of a row by world: mean, interval and seeds on the scale of all groups, and baselines in words. */
    strips(row, measures, values) {
      if (!row) return null;
      const {groups, columns} = this.summary, world = columns.indexOf("world"), size = (name) => this.summary.findings.findIndex((row) => row.measure === name) >>> 0; // none: last
      const own = row.groups.map((group) => groups.findIndex((row) => !row.baseline && JSON.stringify(row.values) === JSON.stringify(group))).filter((place) => place >= 0);
      const shown = measures.filter((name) => own.some((place) => groups[place].measures[name])).sort((a, b) => size(a) - size(b));
      if (!shown.length) return h("p", {class: "note"}, `There are no measures of ${row.name} yet. To see measures, analyse the sweep.`);
      const title = (place) => (world < 0 ? "mean and seeds" : groups[place].values[world]);
      return h("div", {class: "table-box strips", tabindex: "0", role: "region", "aria-label": `Measures of ${row.name}`}, h("table", {class: "runs"},
        h("caption", {class: "note"}, `${row.name}. Dot: mean. Bar: interval of the mean. Strokes: the seeds. All groups in the same world have the same scale.`),
        h("thead", {}, h("tr", {}, h("th", {scope: "col"}, "measure"), own.map((place) => h("th", {scope: "col"}, title(place))))),
        h("tbody", {}, shown.map((name) => h("tr", {}, h("th", {scope: "row"}, h("button", {type: "button", title: "Sort the runs by this measure", onclick: () => this.options.onSort(name)}, this.summary.labels[name] || null, h("small", {}, breakable(name)))),
          own.map((place) => this.strip(place, name, values.get(name) || [], row.model)))))));
    }

    strip(place, name, values, model) {
      const {groups, columns, group_of: groupOf} = this.summary, world = columns.indexOf("world"), summary = groups[place].measures[name];
      if (!summary) return h("td", {class: "note"}, "not measured");
      const alike = groups.filter((group) => group.measures[name] && (world < 0 || group.values[world] === groups[place].values[world]));
      const seeds = values.filter((value, index) => groupOf[index] === place && value !== null), [mean, low, high, n] = summary;
      const scale = marks.scale([...seeds, ...alike.flatMap((group) => group.measures[name].slice(0, 3))].filter((n) => n !== null), marks.WIDTH);
      const baselines = alike.filter((group) => group.baseline).map((group) => `${group.values[columns.indexOf("model")]} ${number(group.measures[name][0])}`);
      return h("td", {}, marks.strip(seeds, summary, scale, this.looks.get(model)?.paint || looks.baseline),
        h("b", {}, number(mean)), low === null ? null : ` [${number(low)}, ${number(high)}]`, h("small", {}, ` n = ${n}, scale ${number(scale.low)} to ${number(scale.high)}`),
        baselines.length ? h("small", {}, `baselines: ${baselines.join(", ")}`) : null);
    }
  }

  foundry.Matrix = Matrix;
})(window.Foundry);
