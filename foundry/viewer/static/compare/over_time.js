"use strict";
/* Draws numbers by step of all compared runs, one row per number, with the largest differences first. A click on a step goes to this step. */
(function (foundry) {
  const {h, fill, number, polyline, redrawn} = foundry.dom;
  const TALL = 56, INSET = 5, SHOWN_AT_FIRST = 3, LINE = 2, STUB = 2;

  class OverTime {
    /** @param options.names the names of the runs; @param options.looks their colours and marks */
    constructor(runs, clock, {names, looks}) {
      Object.assign(this, {runs, clock, names, looks});
      this.values = runs.map(() => ({}));
      this.loaded = runs.map(() => 0);
      this.beginnings = runs.map((run) => run.progress.beginning);
      this.lanes = new Map();
      this.body = h("div");
      this.more = h("div");
      this.folded = h("details", {hidden: true, ontoggle: () => this.redraw()}, h("summary"), this.more);
      this.legend = h("p", {class: "legend"}, names.map((name, index) => h("span", {}, foundry.looks.line(looks[index], {width: 28, height: 10}), ` ${name}`)));
      this.element = h("section", {class: "over-time", "aria-label": "Over time", hidden: true},
        h("h2", {}, "Over time"), this.legend, this.body, this.folded);
      this.redraw = redrawn(this.body, () => {
        this.steps = clock.steps;
        this.lanes.forEach((lane, name) => this.draw(lane, name));
      });
      clock.onChange(() => { if (clock.steps === this.steps) this.lanes.forEach((lane, name) => this.point(lane, name)); else this.redraw(); });
    }

    stroke(pen, index) {
      pen.beginPath();
      pen.strokeStyle = this.looks[index].colour;
      pen.lineWidth = LINE;
      pen.setLineDash(foundry.looks.broken(this.looks[index], LINE));
    }

    /** Load the missing blocks of all runs. */
    async load() {
      if (this.loading) return;
      this.loading = true;
      await Promise.all(this.runs.map((run, index) => this.loadRun(run, index))).finally(() => { this.loading = false; });
      this.offer();
    }

    async loadRun(run, index) {
      if (this.beginnings[index] !== run.progress.beginning) {
        this.beginnings[index] = run.progress.beginning;
        this.values[index] = {};
        this.loaded[index] = 0;
      }
      const size = run.about.marks_per_block;
      while (this.loaded[index] < run.done) {
        const block = await run.once(`by_step/${Math.floor(this.loaded[index] / size)}`);
        if (block.last <= this.loaded[index]) return;
        for (const [name, values] of Object.entries(block.values)) {
          const column = this.values[index][name] = this.values[index][name] || [];
          values.forEach((value, at) => { column[block.first - 1 + at] = value; });
        }
        this.loaded[index] = block.last;
      }
    }

    get known() { return [...new Set(this.values.flatMap((lists) => Object.keys(lists)))]; }

    /** Return how much the runs differ in a number: the mean gap over all steps, divided by the range of the number. */
    apart(name) {
      const lines = this.values.map((lists) => lists[name] || []), isThere = (n) => n !== null && n !== undefined, all = lines.flat().filter(isThere);
      const width = (values) => values.reduce((a, b) => Math.max(a, b), -Infinity) - values.reduce((a, b) => Math.min(a, b), Infinity);
      const steps = Math.max(...lines.map((line) => line.length)), range = all.length ? width(all) : 0;
      const gaps = Array.from({length: steps}, (_, step) => lines.map((line) => line[step]).filter(isThere)).filter((gap) => gap.length > 1).map(width);
      return range && gaps.length ? gaps.reduce((a, b) => a + b, 0) / gaps.length / range : 0;
    }

    /** Show the numbers, with the largest differences first. The order does not change while the runs grow. */
    offer() {
      const {known} = this;
      if (this.lanes.size !== known.length) {
        const apart = new Map(known.map((name) => [name, this.apart(name)])), names = [...known].sort((a, b) => apart.get(b) - apart.get(a));
        this.lanes = new Map(names.map((name) => [name, this.lane(name)]));
        const lanes = [...this.lanes.values()].map((lane) => lane.element), more = lanes.slice(SHOWN_AT_FIRST);
        fill(this.body, lanes.slice(0, SHOWN_AT_FIRST));
        fill(this.more, more);
        this.folded.hidden = !more.length;
        this.folded.firstChild.textContent = `${more.length} more`;
        this.element.hidden = !known.length;
      }
      this.redraw();
    }

    lane(name) {
      const canvas = h("canvas", {class: "over", role: "img"}), note = h("span", {class: "note"});
      const point = (event) => {
        const step = 1 + Math.floor((event.offsetX / canvas.clientWidth) * this.clock.steps);
        if (step === this.clock.step || !this.clock.steps) return;
        this.clock.pause();
        this.clock.seek(Math.min(step, this.clock.steps));
      };
      canvas.addEventListener("pointermove", point);
      canvas.addEventListener("pointerdown", point);
      const dial = new foundry.Dial(canvas, TALL);
      return {canvas, dial, note, element: h("figure", {class: "lane", "data-lane": name}, h("figcaption", {}, h("b", {}, name), " ", note), dial.element)};
    }

    draw(lane, name) {
      const {steps} = this.clock, pen = steps ? lane.dial.pen() : null;
      if (!pen) return;
      const lines = this.values.map((lists) => lists[name] || []), known = lines.flat().filter((n) => n !== null && n !== undefined);
      const low = known.reduce((a, b) => Math.min(a, b), 0), high = known.reduce((a, b) => Math.max(a, b), low) || 1;
      const y = (value) => INSET + (TALL - 2 * INSET) * (1 - (value - low) / (high - low || 1)), column = lane.dial.width / steps;
      lines.forEach((values, index) => {
        this.stroke(pen, index);
        polyline(pen, values, (step) => (step + 0.5) * column, y, STUB);
      });
      Object.assign(lane, {range: `${number(low)} to ${number(high)}`, step: null});
      this.point(lane, name);
    }

    /** Show the position of the clock and the values of its step. */
    point(lane, name) {
      const {step} = this.clock;
      lane.dial.point(this.clock);
      if (lane.step === step || !lane.range) return;
      lane.step = step;
      const said = this.values.map((lists, index) => `${this.names[index]} ${number((lists[name] || [])[step - 1])}`).join(", ");
      lane.note.textContent = `${lane.range} · step ${step}: ${said}`;
      lane.canvas.setAttribute("aria-label", `${name}, step ${step}: ${said}`);
    }
  }

  foundry.OverTime = OverTime;
})(window.Foundry);
