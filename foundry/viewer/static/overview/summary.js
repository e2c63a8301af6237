"use strict";
/* What the analysis found of each group of runs: means, intervals and seeds; a click leaves the runs of a group. */
(function (foundry) {
  const {h, fill, number, breakable, grouped} = foundry.dom, {marks, looks} = foundry;
  const OPEN_WORLDS = 2, FINDINGS = 3;

  /** Return the text that an address has of a group. */
  function nameOf(group) { return group.values.join("|"); }

  class Summary {
    /**
     * @param onPick called with the name of a group that was clicked
     * @param onSort called with the measure whose head was clicked
     */
    constructor(onPick, onSort) {
      this.onPick = onPick;
      this.onSort = onSort;
      this.found = {columns: [], groups: [], group_of: [], part: "", findings: []};
      this.element = h("section", {class: "summary", "aria-label": "What was found of each group"});
    }

    async load(sweep) {
      this.sweep = sweep;
      this.found = await foundry.source.json(`sweep/${sweep}/groups`);
      this.labels = new Map(this.found.findings.map((one) => [one.measure, one.label]));
    }

    /** Return what tells the runs of a group from others; all pass where no such group is known. */
    within(name) {
      const place = this.found.groups.findIndex((one) => !one.baseline && nameOf(one) === name);
      return (row) => place < 0 || this.found.group_of[row.index] === place;
    }

    /**
     * @param values the values of each measure by its name, one per run
     * @param asked.group the name of the group whose runs are shown, or ""
     * @param asked.world the world whose groups are shown, or "" for all
     */
    draw(measures, values, models, asked) {
      const {columns, groups, part} = this.found, world = columns.indexOf("world");
      this.looks = looks.ofModels(models);
      const rows = groups.map((group, place) => ({group, place})).filter(({group}) => world < 0 || !asked.world || group.values[world] === asked.world);
      const tables = grouped(rows, ({group}) => (world < 0 ? "" : group.values[world]));
      const open = new Map([...this.element.querySelectorAll("details")].map((one) => [one.dataset.world, one.open]));
      fill(this.element, part ? h("p", {class: "note"}, `Analysed: ${part}`) : null, this.findings(), tables.size > OPEN_WORLDS ? "Found by group in" : null,
        [...tables].map(([name, ofWorld]) => h("details", {"data-world": name, open: tables.size <= OPEN_WORLDS || open.get(name)},
          h("summary", {}, tables.size > OPEN_WORLDS ? name : `Found by group${name ? ` in ${name}` : ""}`), this.table(ofWorld, measures, values, asked.group))));
    }

    /** The first findings, each with what it is good for and a way to a moment that shows it. */
    findings() {
      const moment = ({level_run: level, reference_run: reference, seed, step, agent}) => h("a", {
        href: `#/compare/${this.sweep}/${level}/${reference}?step=${step}&agent=${agent}`}, `an example: seed ${seed}, step ${step}, agent ${agent}`);
      const shown = this.found.findings.slice(0, FINDINGS);
      return shown.length ? h("ul", {class: "findings", "aria-label": "Findings"}, shown.map((one) =>
        h("li", {}, one.sentence, " ", h("span", {class: "note"}, `(${one.standing}) `), one.moments.length ? moment(one.moments[0]) : null))) : null;
    }

    table(rows, measures, values, chosen) {
      const {columns, findings} = this.found, size = (name) => findings.findIndex((one) => one.measure === name) >>> 0; // none: last
      const shown = measures.filter((name) => rows.some(({group}) => group.measures[name])).sort((a, b) => size(a) - size(b));
      const seeds = (place, name) => this.seeds(place, values.get(name) || []);
      const scales = new Map(shown.map((name) => [name, marks.scale(rows.flatMap(({group, place}) =>
        [...(group.measures[name] || []).slice(0, 3), ...seeds(place, name)].filter((one) => one !== null)), marks.WIDTH)]));
      return h("div", {class: "table-box", tabindex: "0", role: "region", "aria-label": "Groups"}, h("table", {class: "runs groups"},
        h("thead", {}, h("tr", {}, h("th", {scope: "col"}, columns.join(" · ")), shown.map((name) => h("th", {scope: "col"},
          h("button", {type: "button", title: "Sort the runs by it", onclick: () => this.onSort(name)}, this.labels?.get(name), h("small", {}, breakable(name))),
          h("small", {}, `${number(scales.get(name).low)} to ${number(scales.get(name).high)}`))))),
        h("tbody", {}, rows.map(({group, place}) => h("tr", {class: group.baseline ? "baseline" : null},
          h("th", {scope: "row"}, this.pick(group, chosen)),
          shown.map((name) => this.cell(group, name, seeds(place, name), scales.get(name))))))));
    }

    /** Return the values of the runs of a group. */
    seeds(place, values) { return values.filter((value, index) => this.found.group_of[index] === place && value !== null); }

    pick(group, chosen) {
      const name = nameOf(group), label = group.values.join(" · ");
      if (group.baseline) return `${label} (baseline)`;
      return h("button", {type: "button", "aria-pressed": String(name === chosen), onclick: () => this.onPick(name === chosen ? null : name)}, label);
    }

    cell(group, name, seeds, scale) {
      const found = group.measures[name];
      if (!found) return h("td", {}, "–");
      const [mean, low, high, n] = found, model = group.values[this.found.columns.indexOf("model")];
      const colour = group.baseline || !this.looks.has(model) ? looks.baseline : this.looks.get(model).colour;
      return h("td", {}, marks.strip(seeds, found, scale, colour),
        h("b", {}, number(mean)), h("small", {}, ` n = ${n}`), low === null ? null : h("span", {class: "interval"}, ` ${number(low)} to ${number(high)}`));
    }
  }

  foundry.Summary = Summary;
})(window.Foundry);
