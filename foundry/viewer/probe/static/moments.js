"use strict";
/* The page of a probe: a list of its moments, with the largest difference between models first, and each moment in full. */
(function (foundry) {
  const {h, fill, announce, grouped} = foundry.dom;
  const MOST = 500;
  const POLL_MS = 5000;
  const ORDERS = {apart: "largest difference first", recorded: "as recorded"};

  /** Return half of the sum over all choices of gap(k, l, m, n): the numbers of a choice in two counts, and both totals. */
  function overChoices(first, second, gap) {
    const total = (counts) => Object.values(counts).reduce((sum, n) => sum + n, 0), m = total(first), n = total(second);
    return 0.5 * [...new Set([...Object.keys(first), ...Object.keys(second)])]
      .reduce((sum, choice) => sum + gap(first[choice] || 0, second[choice] || 0, m, n), 0);
  }

  /** Return the total variation between two counts of choices, 0 to 1. */
  function apart(first, second) { return overChoices(first, second, (k, l, m, n) => Math.abs(k / m - l / n)); }

  /** Return the mean total variation that chance gives if both counts have the same distribution; see analysis/probes/distance.py. */
  function floorOf(first, second) { return overChoices(first, second, (k, l, m, n) => expectedGap(k + l, m, n)); }

  /** Return the mean of |k / m - (count - k) / n|, if `count` equal choices fall at random into samples of m and n, k of them into the first. */
  function expectedGap(count, m, n) {
    const usual = Math.floor(((count + 1) * (m + 1)) / (m + n + 2)); // begin at the likeliest k, so that no number becomes too large
    const ratio = (k) => ((count - k) * (m - k)) / ((k + 1) * (n - count + k + 1)); // the ratio of one hypergeometric probability to the next
    let gaps = 0, chances = 0;
    const add = (k, chance) => { gaps += chance * Math.abs(k / m - (count - k) / n); chances += chance; };
    for (let k = usual, chance = 1; k <= Math.min(count, m); chance *= ratio(k), k += 1) add(k, chance);
    for (let k = usual - 1, chance = 1; k >= Math.max(0, count - n); k -= 1) add(k, chance /= ratio(k));
    return gaps / chances;
  }

  function mean(values) { return values.length ? values.reduce((sum, value) => sum + value, 0) / values.length : null; }

  function fixed(share) { return share === null ? "–" : share.toFixed(2); }

  function nameOf({kind, step, agent}) { return `${kind}, step ${step}, agent ${agent}`; }

  /** Return the stratum of a moment in words, such as "fire, no message". */
  function situation(strata) {
    return Object.entries(strata).map(([name, value]) => (value === true ? name : value === false ? `no ${name}` : `${name} ${value}`)).join(", ");
  }

  /** Return the most frequent choice. */
  function usual(counts) { return Object.keys(counts).reduce((best, choice) => (counts[choice] > counts[best] ? choice : best)); }

  /** Return one or two names; of more, their number, as in "3 models". */
  function phrase(names, all) {
    if (names.length === all && all > 1) return all === 2 ? "both models" : `all ${all} models`;
    return names.length > 2 ? `${names.length} models` : names.join(" and ");
  }

  /** Return how often each choice occurs in the whole probe. All lists of choices are in this order. */
  function totals(moments) {
    const counted = new Map();
    for (const {counts} of moments.flatMap((moment) => moment.answered)) {
      for (const [choice, count] of Object.entries(counts)) counted.set(choice, (counted.get(choice) || 0) + count);
    }
    return counted;
  }

  /** Replace each choice in the counts by the choice that an edit should turn it into, as "left" by "right" in a mirror. */
  function carried(counts, edit) {
    const shifted = {};
    for (const [choice, count] of Object.entries(counts)) {
      const become = Object.hasOwn(edit.expected, choice) ? edit.expected[choice] : choice;
      shifted[become] = (shifted[become] || 0) + count;
    }
    return shifted;
  }

  class MomentsPage {
    constructor({sweeps, sweep, unreadable}, wanted) {
      this.sweeps = sweeps;
      this.sweep = sweep;
      this.chosen = {order: "apart", edit: 0, format: 0, kind: "", strata: {}};
      this.wanted = wanted;
      this.onKeyDown = (event) => this.key(event);
      document.addEventListener("keydown", this.onKeyDown);
      this.controls = h("div", {class: "controls"});
      this.count = h("p", {class: "note", role: "status"});
      this.list = h("ol", {class: "moments"});
      this.state = h("div");
      this.links = h("span");
      this.element = h("div", {class: "probe"}, this.heading(),
        unreadable.map((why) => h("p", {class: "warning"}, `Not shown: ${why}`)), this.state, this.controls);
    }

    dispose() {
      this.disposed = true;
      document.removeEventListener("keydown", this.onKeyDown);
      if (this.view) this.view.dispose();
    }

    heading() {
      return h("header", {class: "heading"}, h("h1", {}, this.sweep.name), foundry.sweepChoice(this.sweeps, this.sweep), this.links,
        h("a", {href: `#/runs/${this.sweep.id}`}, "runs of this probe"),
        h("details", {class: "asked"}, h("summary", {}, "command"), h("code", {}, `foundry ${this.sweep.asked.join(" ")}`)));
    }

    async open() {
      await this.load();
      this.view = new foundry.MomentView(this.sweep.id, this.probe, await this.looks());
      const {models, moments} = this.probe;
      this.notes = this.noted();
      if (models.length < 2) this.state.before(h("p", {class: "note"}, "Only one model was asked. Choose an edit to see its effect."));
      const edit = this.probe.edits.findIndex((edit) => edit.name === this.wanted.get("edit"));
      this.chosen.edit = edit > 0 ? edit : models.length < 2 && this.probe.edits.length > 1 ? 1 : 0;
      this.element.append(h("div", {class: "probe-stage"},
        h("div", {class: "moments-side"}, h("nav", {class: "moments-box", "aria-label": "Moments"}, this.count, this.list,
          foundry.dom.keys([["J", "next moment"], ["K", "previous moment"], ...this.probe.edits.length > 1 ? [["E", "next edit"]] : [],
            ...foundry.source.live ? [["N", "write a note on this moment"]] : []])), this.notes.element),
        this.view.element));
      this.drawControls();
      const first = this.wanted.has("moment") ? moments[Number(this.wanted.get("moment"))] : undefined;
      this.update(first);
      if (foundry.source.live) this.later();
      return this;
    }

    async load() {
      this.probe = await foundry.source.json(`probe/${this.sweep.id}/moments`);
      this.probe.moments.forEach((moment, index) => { moment.index = index; });
      this.probe.totals = totals(this.probe.moments);
      const {missing} = this.probe;
      fill(this.state, missing ? h("p", {class: "warning"}, `${missing} runs are not complete. This page leaves them out.`) : null);
    }

    /** Return the notes on all moments. */
    noted() {
      const {moments} = this.probe, runs = [...new Set(moments.map((moment) => moment.run))];
      const notes = new foundry.Notes(this.sweep.id, runs.map((id) => ({id, name: id})), {
        where: () => { const {run, step, agent, index} = this.moment; return {run, step, agent, moment: index}; },
        name: ({moment}) => nameOf(moments[moment]), onPick: ({moment}) => this.go(this.probe.moments[moment])});
      notes.load();
      return notes;
    }

    isAnswered() { return this.probe.moments.some((moment) => moment.answered.length); }

    /** Load the moments again from time to time until all runs are complete. */
    later() {
      const {missing} = this.probe;
      if (missing) setTimeout(() => this.again(missing), POLL_MS);
    }

    async again(before) {
      if (this.disposed) return;
      try {
        await this.load();
        if (this.probe.missing !== before) this.update(this.moment && this.probe.moments[this.moment.index]);
      } catch (error) {
        fill(this.state, h("p", {class: "warning"}, `The server does not answer: ${error.message}`));
      }
      this.later();
    }

    /** Show the links to the reports; return the colours and marks that the models have on all pages of the sweep. */
    async looks() {
      const {links, models} = await foundry.source.json(`sweep/${this.sweep.id}`);
      fill(this.links, links.filter((link) => link.kind === "html").map((link) =>
        [h("a", {href: foundry.source.file(this.sweep.id, link.path), target: "_blank", rel: "noopener"}, link.path), " "]));
      const modelOf = (name) => models.find((model) => name === model || name.startsWith(`${model} / `));
      return foundry.looks.ofItems(this.probe.models.map(modelOf), models);
    }

    strata() {
      const values = new Map();
      for (const {strata} of this.probe.moments) {
        for (const [name, value] of Object.entries(strata)) values.set(name, new Set([...(values.get(name) || []), String(value)]));
      }
      return values;
    }

    drawControls() {
      const {edits, formats, moments} = this.probe, kinds = [...new Set(moments.map((moment) => moment.kind))].sort();
      const select = (label, options, value, take) => h("label", {}, `${label} `, h("select", {"aria-label": label, onchange: (event) => { take(event.target.value); this.update(this.moment); }},
        options.map(([key, text]) => h("option", {value: String(key), selected: String(key) === String(value)}, text))));
      const every = (values) => [["", "all"], ...values.map((value) => [value, value])];
      fill(this.controls,
        select("Order", Object.entries(ORDERS), this.chosen.order, (value) => { this.chosen.order = value; }),
        edits.length > 1 ? this.edits = select("Edit", edits.map((edit, index) => [index, index ? `${edit.name} (${edit.leaves})` : edit.name]), this.chosen.edit, (value) => { this.chosen.edit = Number(value); }) : null,
        formats.length > 1 ? select("Format", formats.map((name, index) => [index, name]), this.chosen.format, (value) => { this.chosen.format = Number(value); }) : null,
        kinds.length > 1 ? select("Kind", every(kinds), this.chosen.kind, (value) => { this.chosen.kind = value; }) : null,
        [...this.strata()].map(([name, values]) => (values.size > 1 ? select(name, every([...values].sort()), "", (value) => { this.chosen.strata[name] = value; }) : null)));
    }

    /** Return the distance between the choices of models in a moment, or between choices with and without the edit, and its value by chance. */
    gap(moment) {
      const pairs = this.pairs(moment), distance = mean(pairs.map((pair) => apart(...pair))), floor = mean(pairs.map((pair) => floorOf(...pair)));
      return {distance, floor, excess: distance === null ? null : distance - floor};
    }

    /** Describe a moment: its situation, and the most frequent choices, as in "stay → left" for a choice that an edit changes. */
    gist({strata, answered}) {
      const {edit, format} = this.chosen, {models} = this.probe;
      const of = (model, which) => answered.find((row) => row.model === model && row.edit === which && row.format === (edit ? 0 : format))?.counts;
      const asked = models.map((name, model) => ({name, before: of(model, 0), after: of(model, edit)})).filter(({after}) => after);
      const choice = ({before, after}) => [...new Set([before || after, after].map(usual))].join(" → ");
      const parts = [...grouped(asked, choice)].sort(([, a], [, b]) => b.length - a.length)
        .map(([what, mine]) => [phrase(mine.map((model) => model.name), models.length), what]);
      const where = situation(strata);
      return `${where ? `${where}. ` : ""}Most frequent choice: ${parts.map(([who, what]) => `${what} (${who})`).join("; ")}.`.replace(/^./, (first) => first.toUpperCase());
    }

    pairs(moment) {
      const {edit, format} = this.chosen, of = (which, written) => moment.answered.filter((row) => row.edit === which && row.format === written);
      if (!edit) {
        const counts = of(0, format).map((row) => row.counts);
        return counts.flatMap((first, index) => counts.slice(index + 1).map((other) => [first, other]));
      }
      const before = new Map(of(0, 0).map((row) => [row.model, row.counts]));
      return of(edit, 0).filter((row) => before.has(row.model)).map((row) => [carried(before.get(row.model), this.probe.edits[edit]), row.counts]);
    }

    matching() {
      const {edit, format, kind, strata, order} = this.chosen;
      const items = this.probe.moments
        .filter((moment) => (!kind || moment.kind === kind) && Object.entries(strata).every(([name, value]) => !value || String(moment.strata[name]) === value))
        .filter((moment) => moment.answered.some((answer) => answer.edit === edit && answer.format === (edit ? 0 : format)))
        .map((moment) => ({moment, ...this.gap(moment)}));
      const by = (name) => (a, b) => (b[name] ?? -2) - (a[name] ?? -2);
      return order === "apart" ? items.sort((a, b) => by("excess")(a, b) || by("distance")(a, b) || a.moment.index - b.moment.index) : items;
    }

    update(wanted) {
      this.shown = this.matching();
      this.count.textContent = `${this.shown.length} of ${this.probe.moments.length} moments${this.shown.length > MOST ? `, the first ${MOST}` : ""}. Number and dark bar: how much more the choices differ than chance explains, 0 to 1. Pale bar: the part that chance explains.`;
      fill(this.list, this.shown.slice(0, MOST).map((item) => this.item(item)));
      const there = this.shown.find((item) => item.moment === wanted) || this.shown[0];
      this.notes.element.hidden = !(this.moment || there);
      if (there) this.go(there.moment); else this.view.say("No moment matches the filters. Remove a filter.");
    }

    item({moment, distance, floor, excess}) {
      const bar = h("i", {class: "bar"}, h("b", {class: "chance"}), h("b"));
      [Math.min(distance, floor), Math.max(excess, 0)].forEach((share, index) => { bar.children[index].style.width = `${100 * share}%`; });
      return h("li", {}, h("button", {type: "button", "data-moment": moment.index, onclick: () => this.go(moment)},
        h("strong", {class: "excess"}, fixed(excess)), bar,
        h("span", {class: "distance"}, distance === null ? "nothing to compare" : `${fixed(distance)} in all, ${fixed(floor)} by chance`),
        h("span", {class: "gist"}, this.gist(moment)), h("small", {}, `${nameOf(moment)} · ${moment.run}`)));
    }

    go(moment) {
      this.moment = moment;
      for (const button of this.list.querySelectorAll("button")) {
        const mine = Number(button.dataset.moment) === moment.index;
        button.toggleAttribute("aria-current", mine);
        if (mine) { button.setAttribute("aria-current", "true"); this.list.scrollTop = button.offsetTop - this.list.offsetTop - this.list.clientHeight / 2; }
      }
      const {edit, format} = this.chosen, name = this.probe.edits[edit].name;
      foundry.address.change({moment: moment.index, edit: edit ? name : null});
      this.view.show(moment, {edit, format: edit ? 0 : format, gist: this.gist(moment)});
    }

    key(event) {
      if (foundry.dom.isTyping(event) || !this.shown) return;
      const key = event.key.toLowerCase();
      if (key === "j" || key === "k") {
        const at = this.shown.findIndex((item) => item.moment === this.moment), next = this.shown[at + (key === "j" ? 1 : -1)];
        if (next) { this.go(next.moment); announce(`Moment ${at + (key === "j" ? 2 : 0)} of ${this.shown.length}`); }
      } else if (key === "e" && this.edits) {
        this.chosen.edit = (this.chosen.edit + 1) % this.probe.edits.length;
        this.edits.querySelector("select").value = String(this.chosen.edit);
        this.update(this.moment);
        announce(`Edit ${this.probe.edits[this.chosen.edit].name}`);
      } else if (key === "n" && this.moment && foundry.source.live) this.notes.write();
      else return;
      event.preventDefault();
    }
  }

  foundry.MomentsPage = MomentsPage;
  foundry.probes = {apart, carried, floorOf};
})(window.Foundry);
