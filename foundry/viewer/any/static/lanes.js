"use strict";
/* Draws agents over time: one row per agent, one column per step, coloured by action. Below is the utility, if there is one. */
(function (foundry) {
  const {h, fill, color, number, penOf, polyline, redrawn} = foundry.dom;
  const GUTTER = 46, AXIS = 18, CHART = 84, MARGIN = 4;
  const HIGH = 340, LARGEST = 24, SMALLEST = 2, STUB = 4;
  const MOST_PARTS = 4;
  const MOST_COLUMNS = 4096, HATCHED_PX = 3, HATCH = 5;

  function sized(canvas, width, height) {
    canvas.style.height = `${height}px`;
    const pen = penOf(canvas, width, height);
    pen.font = "11px system-ui, sans-serif";
    return pen;
  }

  class Lanes {
    /** @param onPick called with the agent and the step that the user clicked */
    constructor(data, {onPick}) {
      this.data = data;
      this.onPick = onPick;
      this.run = new foundry.RunLanes(data);
      this.selected = null;
      this.position = 1;
      this.canvas = h("canvas", {class: "lanes", role: "img", "aria-label": "Agents over time"});
      this.chart = h("canvas", {class: "utility", role: "img", "aria-label": "Utility over time"});
      this.ofChosen = h("span", {hidden: true}, h("i", {class: "of-chosen"}, "▬"), " of the chosen agent");
      this.utility = h("div", {hidden: true}, this.chart, h("p", {class: "legend"}, h("span", {}, "Utility: mean over agents, with the range from lowest to highest"),
        this.ofChosen));
      this.choice = h("select", {"aria-label": "Kind of decision", hidden: true, onchange: () => { this.kind = this.choice.value; this.begin(); this.redraw(); }});
      this.legend = h("p", {class: "legend"});
      this.element = h("figure", {class: "lanes-box"}, h("div", {class: "row"}, h("figcaption", {}, "Agents over time"), this.choice),
        h("div", {class: "lanes-scroll"}, this.canvas), this.legend, this.utility);
      this.canvas.addEventListener("click", (event) => this.pick(event));
      this.canvas.addEventListener("pointermove", (event) => this.tell(event));
      window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.begin());
      this.redraw = redrawn(this.element, () => this.draw());
    }

    async load() {
      if (this.run.beginning !== this.data.progress.beginning) this.sheet = null;
      await this.run.load(() => { this.show(); });
    }

    /** Show newly loaded data. */
    show() {
      const kinds = this.run.deciding();
      if (this.kind === undefined || !kinds.includes(this.kind)) [this.kind] = kinds;
      this.choice.hidden = kinds.length < 2;
      if (this.choice.childElementCount !== kinds.length) {
        fill(this.choice, kinds.map((kind) => h("option", {value: kind, selected: kind === this.kind}, kind || "decisions")));
      }
      this.begin();
      this.redraw();
    }

    /** Paint every decision as one pixel of an image, which is later stretched. Several decisions in a step share its column. */
    begin() {
      const {run, data} = this, agents = Math.max(1, data.about.agents);
      this.colours = new foundry.Colours(data.about.actions[this.kind] || null);
      this.counts = new Map();
      this.every = Math.ceil(Math.max(1, run.loaded) / MOST_COLUMNS);
      const columns = Math.max(1, Math.ceil(run.loaded / this.every));
      this.sheet = document.createElement("canvas");
      this.unreadable = [];
      this.parts = 1;
      this.eachTurn((block, at, turn) => {
        this.colours.learn(block.action[at]);
        this.parts = Math.max(this.parts, Math.min(MOST_PARTS, turn + 1));
      });
      const width = columns * this.parts;
      [this.sheet.width, this.sheet.height] = [width, agents];
      const pen = this.sheet.getContext("2d"), pixels = pen.createImageData(width, agents);
      this.eachTurn((block, at, turn) => this.paint(pixels, block, at, turn));
      pen.putImageData(pixels, 0, 0);
      this.drawLegend();
    }

    /** Visit every decision of the kind, with the number of earlier decisions of its agent in the step. */
    eachTurn(visit) {
      let step = null, turns = new Map();
      this.run.each(this.kind, (block, at) => {
        if (block.step[at] !== step) [step, turns] = [block.step[at], new Map()];
        const turn = turns.get(block.agent[at]) || 0;
        turns.set(block.agent[at], turn + 1);
        visit(block, at, turn);
      });
    }

    paint(pixels, block, at, turn) {
      const {[at]: step} = block.step, {[at]: agent} = block.agent, unreadable = this.run.isUnreadable(block, at);
      const key = unreadable ? "\u0000unreadable" : block.action[at];
      this.counts.set(key, (this.counts.get(key) || 0) + 1);
      if ((step - 1) % this.every) return;
      const {parts} = this, part = Math.min(turn, parts - 1), before = this.unreadable[this.unreadable.length - 1];
      if (part && before && before.step === step && before.agent === agent) before.to = part;
      if (unreadable) this.unreadable.push({step, agent, from: part, to: parts});
      const first = parts * (step - 1) / this.every, [red, green, blue] = this.colours.of(block.action[at], unreadable);
      for (let column = first + part; column < first + parts; column += 1) pixels.data.set([red, green, blue, 255], 4 * (agent * pixels.width + column));
    }

    drawLegend() {
      const {colours, counts} = this, swatch = (rgb, more = "") => h("i", {class: `swatch ${more}`, "data-color": rgb.join()});
      const total = [...counts.values()].reduce((sum, n) => sum + n, 0), share = (key) => `${Math.round((100 * (counts.get(key) || 0)) / Math.max(1, total))} %`;
      const labels = [...colours.labels].map(([label, rgb]) => h("span", {}, swatch(rgb), h("bdi", {}, ` ${label}`), h("small", {}, ` ${share(label)}`)));
      const [low, high] = colours.range;
      const scale = colours.hasNumbers || (!labels.length && Number.isFinite(low)) ? h("span", {class: "scale"}, number(low), this.ramp(), number(high)) : null;
      const others = [[null, "no action", colours.quiet], ["\u0000unreadable", "unreadable", colours.bad, "hatched"]].filter(([key]) => counts.get(key))
        .map(([key, text, rgb, more]) => h("span", {}, swatch(rgb, more), ` ${text}`, h("small", {}, ` ${share(key)}`)));
      fill(this.legend, labels, scale, others, this.every > 1 ? h("span", {}, `every ${this.every}th step is shown`) : null);
      this.legend.querySelectorAll(".swatch").forEach((swatch) => { swatch.style.backgroundColor = `rgb(${swatch.dataset.color})`; });
    }

    ramp() {
      const ramp = h("i", {class: "ramp"});
      ramp.style.background = `linear-gradient(to right, rgb(${this.colours.onScale(0)}), rgb(${this.colours.onScale(1)}))`;
      return ramp;
    }

    select(agent) { this.selected = agent; this.ofChosen.hidden = agent === null; this.redraw(); }

    /** Show the position of the clock. */
    seek(position) { this.position = position; this.redraw(); }

    get step() { return Math.max(1, Math.min(Math.floor(this.position), this.run.loaded)); }

    measure() {
      const agents = Math.max(1, this.data.about.agents);
      this.width = this.canvas.clientWidth;
      this.lane = Math.max(SMALLEST, Math.min(LARGEST, Math.floor(HIGH / agents)));
      this.column = (this.width - GUTTER - MARGIN) / Math.max(1, this.run.loaded);
      this.high = agents * this.lane;
    }

    left(step) { return GUTTER + (step - 1) * this.column; }

    draw() {
      this.utility.hidden = !this.run.hasUtility;
      if (!this.canvas.clientWidth || !this.sheet) return;
      this.measure();
      const pen = sized(this.canvas, this.width, this.high + AXIS);
      pen.imageSmoothingEnabled = false;
      pen.drawImage(this.sheet, 0, 0, this.sheet.width, this.sheet.height, GUTTER, 0, (this.sheet.width / this.parts) * this.every * this.column, this.high);
      this.drawLines(pen);
      this.drawSigns(pen);
      this.drawNames(pen);
      this.drawAxis(pen);
      this.drawCursor(pen, this.high);
      if (this.run.hasUtility) this.drawUtility();
      this.canvas.setAttribute("aria-label", this.describe());
    }

    drawLines(pen) {
      pen.strokeStyle = color("paper");
      pen.lineWidth = 1;
      pen.beginPath();
      if (this.lane >= 6) for (let agent = 1; agent < this.data.about.agents; agent += 1) { pen.moveTo(GUTTER, agent * this.lane); pen.lineTo(this.width, agent * this.lane); }
      if (this.column >= 6) for (let step = 2; step <= this.run.loaded; step += 1) { pen.moveTo(this.left(step), 0); pen.lineTo(this.left(step), this.high); }
      pen.stroke();
    }

    /** Hatch unreadable decisions if there is room, so that they differ not only by colour. */
    drawSigns(pen) {
      const wide = this.column / this.parts;
      if (this.lane < HATCHED_PX || wide < HATCHED_PX) return;
      pen.save();
      pen.beginPath();
      for (const {step, agent, from, to} of this.unreadable) pen.rect(this.left(step) + from * wide, agent * this.lane, (to - from) * wide, this.lane);
      pen.clip();
      pen.beginPath();
      for (let at = -this.high; at < this.width; at += HATCH) { pen.moveTo(at, this.high); pen.lineTo(at + this.high, 0); }
      pen.strokeStyle = color("paper");
      pen.lineWidth = 1.5;
      pen.stroke();
      pen.restore();
    }

    drawNames(pen) {
      pen.textAlign = "right";
      pen.textBaseline = "middle";
      const every = Math.ceil(11 / this.lane);
      for (let agent = 0; agent < this.data.about.agents; agent += every) {
        pen.fillStyle = color(agent === this.selected ? "select" : "soft");
        pen.fillText(String(agent), GUTTER - 5, Math.max(6, (agent + 0.5) * this.lane));
      }
    }

    drawAxis(pen) {
      const wanted = Math.max(1, this.run.loaded / Math.max(1, (this.width - GUTTER) / 60));
      const every = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000].find((gap) => gap >= wanted) || 50000;
      pen.fillStyle = color("soft");
      pen.textBaseline = "top";
      for (let step = 1; step <= this.run.loaded; step = step === 1 && every > 1 ? every : step + every) {
        pen.textAlign = "center";
        pen.fillText(String(step), Math.min(this.left(step) + this.column / 2, this.width - 10), this.high + 4);
      }
    }

    drawScale(pen, low, high) {
      pen.fillStyle = color("soft");
      pen.textAlign = "right";
      pen.textBaseline = "top";
      pen.fillText(number(high), GUTTER - 5, 3);
      pen.textBaseline = "bottom";
      pen.fillText(number(low), GUTTER - 5, CHART - 3);
    }

    drawCursor(pen, high) {
      pen.strokeStyle = color("ink");
      pen.lineWidth = 2;
      pen.strokeRect(this.left(this.step), 1, Math.max(2, this.column), high - 2);
      if (this.selected === null || this.selected >= this.data.about.agents || high !== this.high) return;
      pen.strokeStyle = color("select");
      pen.strokeRect(GUTTER, this.selected * this.lane, this.run.loaded * this.column, this.lane);
    }

    /** Draw the mean and the range of the agents' utilities, and the utility of the chosen agent. */
    drawUtility() {
      this.chart.style.width = `${this.width}px`; // a scroll bar beside the rows takes up space
      const pen = sized(this.chart, this.width, CHART), {utilities} = this.run;
      const lows = utilities.map((sums) => sums.low), highs = utilities.map((sums) => sums.high);
      let low = Infinity, high = -Infinity;
      lows.forEach((value) => { low = Math.min(low, value); });
      highs.forEach((value) => { high = Math.max(high, value); });
      if (high === low) { low -= 1; high += 1; }
      const y = (value) => 6 + (CHART - 12) * (1 - (value - low) / (high - low)), x = (step) => this.left(step) + this.column / 2;
      pen.beginPath();
      utilities.forEach((sums, index) => pen.lineTo(x(index + 1), y(sums.high)));
      [...utilities.keys()].reverse().forEach((index) => utilities[index] && pen.lineTo(x(index + 1), y(utilities[index].low)));
      pen.globalAlpha = 0.2;
      pen.fillStyle = color("accent");
      pen.fill();
      pen.globalAlpha = 1;
      this.line(pen, utilities.map((sums) => sums.sum / sums.count), (at) => x(at + 1), y, "accent");
      if (this.selected !== null) this.line(pen, this.ofAgent(), (at) => x(at + 1), y, "select");
      this.drawScale(pen, low, high);
      this.drawCursor(pen, CHART);
      const here = utilities[this.step - 1];
      this.chart.setAttribute("aria-label", here ? `Utility at step ${this.step}: mean ${number(here.sum / here.count)}, from ${number(here.low)} to ${number(here.high)}` : "Utility over time");
    }

    line(pen, values, x, y, tone) {
      pen.strokeStyle = color(tone);
      pen.lineWidth = 2;
      polyline(pen, values, x, y, values.length === 1 ? STUB : 0);
    }

    /** Return the chosen agent's utilities by step. They are computed again only if new data were loaded. */
    ofAgent() {
      const key = `${this.selected}/${this.run.loaded}`;
      if (this.ownKey !== key) {
        this.ownKey = key;
        this.own = [];
        for (const kind of this.run.kinds) this.run.each(kind, (block, at) => {
          if (block.agent[at] === this.selected && typeof block.utility[at] === "number") this.own[block.step[at] - 1] = block.utility[at];
        });
      }
      return this.own;
    }

    /** Return the [agent, step] under the pointer, or null. */
    under(event) {
      const agent = Math.floor(event.offsetY / this.lane), step = 1 + Math.floor((event.offsetX - GUTTER) / this.column);
      return agent >= 0 && agent < this.data.about.agents && step <= this.run.loaded ? [agent, step] : null;
    }

    pick(event) {
      const place = this.sheet && this.under(event);
      if (place) this.onPick(place[0], place[1] >= 1 ? place[1] : null);
    }

    tell(event) {
      const place = this.sheet && this.under(event);
      this.canvas.title = place && place[1] >= 1 ? `agent ${place[0]}, step ${place[1]}: ${this.doing(place[1]).get(place[0]) ?? "no decision"}` : "";
    }

    /** Return the actions of all agents at a step, in words. */
    doing(step) {
      const actions = new Map();
      this.run.each(this.kind, (block, at) => {
        const words = this.run.isUnreadable(block, at) ? this.data.about.outcomes[block.outcome[at]] : block.action[at] === null ? "no action" : String(block.action[at]);
        actions.set(block.agent[at], actions.has(block.agent[at]) ? `${actions.get(block.agent[at])}, then ${words}` : words);
      }, step);
      return actions;
    }

    /** Return the step whose actions are shown in words. */
    describe() {
      const counts = new Map();
      for (const action of this.doing(this.step).values()) counts.set(action, (counts.get(action) || 0) + 1);
      const most = [...counts].sort((a, b) => b[1] - a[1]).slice(0, 8);
      return `${this.data.about.agents} agents. Step ${this.step}: ${most.map(([action, count]) => `${count} ${action}`).join(", ") || "no decision"}.`;
    }
  }

  Object.assign(Lanes, {sized, CHART});
  foundry.Lanes = Lanes;
})(window.Foundry);
