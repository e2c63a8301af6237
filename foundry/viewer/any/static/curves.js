"use strict";
/* Draws the numbers that a world records at each step as lines below the rows of agents, with one column per step as there. */
(function (foundry) {
  const {h, fill, number, polyline, redrawn} = foundry.dom;
  const DASHES = [6, 4], INSET = 6, STUB = 3;

  class Curves {
    /** @param lanes the rows of agents, which give the position of each step */
    constructor(data, lanes) {
      this.data = data;
      this.lanes = lanes;
      this.shown = 0;
      this.reset();
      const {curves} = data.about;
      this.choice = h("select", {"aria-label": "Numbers over time", hidden: curves.length < 2, onchange: () => { this.shown = Number(this.choice.value); this.redraw(); }},
        curves.map((curve, index) => h("option", {value: String(index)}, curve.name)));
      this.title = h("figcaption");
      this.canvas = h("canvas", {class: "curves", role: "img", "aria-label": "Numbers over time"});
      this.legend = h("p", {class: "legend"});
      this.known = h("p", {class: "legend"});
      this.element = h("figure", {class: "lanes-box", hidden: !curves.length}, h("div", {class: "row"}, this.title, this.choice), this.canvas, this.legend, this.known);
      this.redraw = redrawn(this.element, () => this.draw());
    }

    reset() {
      this.beginning = this.data.progress.beginning;
      this.values = this.data.about.curves.map((curve) => curve.keys.map(() => ({low: [], mean: [], high: []})));
      this.loaded = 0;
    }

    /** Load the missing blocks. */
    async load() {
      if (!this.values.length && !this.data.about.curves.length) return;
      if (this.beginning !== this.data.progress.beginning) this.reset();
      const size = this.data.about.marks_per_block, {beginning} = this;
      while (this.loaded < this.data.done) {
        const block = await this.data.once(`curves/${Math.floor(this.loaded / size)}`);
        if (this.beginning !== beginning || block.last <= this.loaded) return;
        block.values.forEach((keys, index) => keys.forEach((key, at) => this.take(this.values[index][at], key, block.first)));
        this.loaded = block.last;
        this.redraw();
      }
    }

    /** Store the values of a block at its first step. A block that is loaded again may be longer. */
    take(known, block, first) {
      for (const name of ["low", "mean", "high"]) known[name].splice(first - 1, Infinity, ...block[name]);
    }

    /** Return the names, values and colours of the visible lines. */
    lines() {
      const {keys} = this.data.about.curves[this.shown], {labels} = foundry.palette;
      const lines = keys.map((key, at) => ({key, colour: labels[at % labels.length], ...this.values[this.shown][at]}));
      return lines.filter(({mean}) => mean.some((value) => value !== null));
    }

    draw() {
      if (!this.loaded || !this.canvas.clientWidth) return;
      const {sized, CHART} = foundry.Lanes, {lanes} = this, lines = this.lines();
      lanes.measure();
      const {score} = this.data.analysis;
      this.title.textContent = `${this.data.about.curves[this.shown].name} over time`;
      this.known.textContent = score?.known ? `Score ${number(score.value)}. Known scores: ${score.known}.` : "";
      this.canvas.style.width = `${lanes.width}px`;
      const pen = sized(this.canvas, lanes.width, CHART), known = lines.flatMap((line) => [...line.low, ...line.high]).filter((n) => n !== null);
      const low = known.reduce((a, b) => Math.min(a, b), 0), most = known.reduce((a, b) => Math.max(a, b), low), high = most === low ? low + 1 : most;
      const y = (value) => INSET + (CHART - 2 * INSET) * (1 - (value - low) / (high - low)), x = (index) => lanes.left(index + 1) + lanes.column / 2;
      for (const line of lines) {
        this.band(pen, line, x, y);
        this.line(pen, line, x, y);
      }
      lanes.drawScale(pen, low, high);
      lanes.drawCursor(pen, CHART);
      this.tell(lines);
    }

    band(pen, {low, high, colour}, x, y) {
      pen.fillStyle = colour;
      pen.globalAlpha = 0.2;
      low.forEach((value, index) => {
        if (value === null || value === high[index]) return;
        pen.fillRect(x(index) - this.lanes.column / 2, y(high[index]), this.lanes.column, Math.max(1, y(value) - y(high[index])));
      });
      pen.globalAlpha = 1;
    }

    /** Draw the mean over time. A line that never changes, such as a capacity, is dashed. */
    line(pen, {mean, colour}, x, y) {
      const known = mean.filter((n) => n !== null), first = known[0];
      pen.setLineDash(known.length > 1 && known.every((n) => n === first) ? DASHES : []);
      pen.strokeStyle = colour;
      pen.lineWidth = 2;
      polyline(pen, mean, x, y, STUB);
      pen.setLineDash([]);
    }

    /** Show the names of the lines and their values at the step. */
    tell(lines) {
      const at = this.lanes.step - 1;
      const said = lines.map(({key, low, mean, high}) => `${key} ${mean[at] === null || mean[at] === undefined ? "–" : number(mean[at], 6)}${
        low[at] === high[at] ? "" : ` (${number(low[at], 6)} to ${number(high[at], 6)})`}`);
      fill(this.legend, lines.map(({colour}, index) => h("span", {}, h("i", {class: "swatch", "data-color": colour}), ` ${said[index]}`)));
      this.legend.querySelectorAll(".swatch").forEach((swatch) => { swatch.style.backgroundColor = swatch.dataset.color; });
      this.canvas.setAttribute("aria-label", `Step ${at + 1}: ${said.join(", ")}`);
    }
  }

  foundry.Curves = Curves;
})(window.Foundry);
