"use strict";
/* Draws all compared runs of one 2D world on a single map: positions, lines between the positions of the same agent, and trails or a heat map of some steps. */
(function (foundry) {
  const {h} = foundry.dom;
  const AWAY = 8, MOST_STEPS = 500, SHORT = 60;
  const PLACED = ["places", "fires", "walls", "exits", "zones"];

  class Overlay extends foundry.Grid {
    /** @param options.names and options.looks of the runs; options.onPick is called with an agent or null */
    constructor(runs, {names, looks, onPick}) {
      super(runs[0], {onPick: (spot) => onPick(spot === null ? null : spot % runs[0].about.agents)});
      const apart = PLACED.filter((part) => runs.some((run) => JSON.stringify(run.about[part]) !== JSON.stringify(runs[0].about[part])));
      this.about = {...runs[0].about, ...Object.fromEntries(apart.map((part) => [part, []]))};
      Object.assign(this, {runs, names, looks, ways: runs.map(() => new Map()), layer: {canvas: h("canvas")}, counted: {}});
      this.joined = h("input", {type: "checkbox", checked: true, onchange: () => this.redraw()});
      this.what = h("select", {"aria-label": "Steps drawn as", onchange: () => this.look()},
        ["neither trails nor heat", "trails", "heat map of all", ...names.map((name) => `heat map of ${name}`)].map((text, index) => h("option", {value: String(index - 3)}, text)));
      const end = (label, value) => h("input", {type: "number", min: "1", value, "aria-label": label, onchange: () => this.look()});
      this.from = end("From step", "1");
      this.to = end("To step", String(Math.max(1, Math.min(MOST_STEPS, this.last()))));
      this.said = h("span", {class: "note", role: "status"});
      this.box = h("section", {class: "overlay", "aria-label": "All on one map"},
        h("div", {class: "choices"}, h("label", {}, this.joined, " connect the same agent"), this.what, h("label", {}, "from step ", this.from), h("label", {}, "to ", this.to), this.said),
        apart.length ? h("p", {class: "note"}, `The map does not show ${apart.join(" or ")}, because they differ between the runs.`) : null,
        h("p", {class: "legend"}, names.map((name, index) => h("span", {}, foundry.looks.mark(looks[index]), ` ${name}`))), this.element);
    }

    /** Return the last recorded step of the longest run. */
    last() { return Math.max(...this.runs.map((run) => run.done)); }

    /** Begin the outline of an agent. Its form, and not only its colour, shows the run. */
    mark(pen, index, x, y, radius) {
      foundry.looks.trace(pen, this.looks[index].marker, x, y, 1.2 * radius);
    }

    /** Load the chosen range of steps and show it. */
    async look() {
      const last = this.last(), within = (value) => Math.max(1, Math.min(Math.floor(Number(value)) || 1, last));
      const from = within(this.from.value), to = Math.min(Math.max(from, within(this.to.value)), from + MOST_STEPS - 1), wanted = `${from} ${to}`;
      [this.from.value, this.to.value] = [from, to];
      this.said.textContent = to - from + 1 === MOST_STEPS ? `The paths of at most ${MOST_STEPS} steps are drawn.` : "";
      if (this.what.value !== "-3" && this.wanted !== wanted) {
        this.wanted = wanted;
        const ways = await Promise.all(this.runs.map((run) => this.way(run, from, Math.min(to, run.done))));
        if (this.wanted === wanted) this.ways = ways;
      }
      this.redraw();
    }

    /** Return for every step of a range the positions of the agents before the step, and whether they were present. */
    async way(run, from, to) {
      const places = new Map(), {agents} = run.about;
      for (let step = from; step <= to; step += 1) {
        const chunk = await run.load(step), base = (step - chunk.first) * agents;
        places.set(step, {x: chunk.x.subarray(base, base + agents), y: chunk.y.subarray(base, base + agents), flags: chunk.flags.subarray(base, base + agents)});
      }
      return places;
    }

    redraw() {
      if (!this.runs || !this.element.clientWidth) return;
      this.retone();
      const pen = this.measure();
      pen.fillStyle = this.tones.paper;
      pen.fillRect(0, 0, this.width, this.height);
      this.drawField(pen);
      this.drawFurniture(pen);
      const what = Number(this.what.value);
      this.about.places.forEach((place) => this.drawPlace(pen, place, this.tones.place, place.name));
      if (what >= -2) this.drawLayer(pen, what);
      this.drawFires(pen);
      this.drawRuns(pen);
      this.drawLabels(pen);
    }

    /** Draw the heat map or the trails. Draw them again only if the range, run, agent, part or colours change. */
    drawLayer(pen, what) {
      const {canvas, ways, layer} = this, wanted = [what, this.selected, this.cell, ...this.centre, canvas.width, canvas.height, this.tones.ink].join();
      if (layer.ways !== ways || layer.wanted !== wanted) {
        Object.assign(layer, {ways, wanted});
        Object.assign(layer.canvas, {width: canvas.width, height: canvas.height});
        const its = layer.canvas.getContext("2d");
        its.setTransform(pen.getTransform());
        if (what === -2) this.drawTrails(its); else this.drawHeat(its, what);
      }
      pen.drawImage(layer.canvas, 0, 0, this.width, this.height);
    }

    /** Return the number of agent-steps in each cell, [x, y, count]; computed once for a range and a choice of runs. */
    stays(only) {
      const {ways, counted} = this;
      if (counted.ways !== ways || counted.only !== only) Object.assign(counted, {ways, only, cells: this.countStays(only)});
      return counted.cells;
    }

    countStays(only) {
      const size = this.about.half_size, side = 2 * size + 1, counts = new Uint32Array(side * side), cells = [];
      this.ways.forEach((way, index) => {
        if (only >= 0 && index !== only) return;
        for (const {x, y, flags} of way.values()) {
          x.forEach((at, agent) => { if (!(flags[agent] & AWAY)) counts[(at + size) * side + y[agent] + size] += 1; });
        }
      });
      counts.forEach((count, at) => { if (count) cells.push([Math.floor(at / side) - size, at % side - size, count]); });
      return cells;
    }

    drawHeat(pen, only) {
      const cells = this.stays(only), most = cells.reduce((a, [, , count]) => Math.max(a, count), 1), tone = only >= 0 ? this.looks[only].colour : this.tones.ink;
      for (const [x, y, count] of cells) this.fill(pen, x, y, tone, 0.08 + 0.72 * count / most);
      this.said.textContent = `darkest: ${most} visits of a cell`;
    }

    drawTrails(pen) {
      this.ways.forEach((way, index) => {
        const steps = [...way.values()], chosen = this.selected;
        pen.beginPath();
        for (let agent = 0; agent < this.about.agents; agent += 1) {
          if (chosen !== null && agent !== chosen) continue;
          let away = true;
          for (const {x, y, flags} of steps) {
            const gone = flags[agent] & AWAY, at = [this.toX(x[agent]) + index * 2, this.toY(y[agent]) + index * 2];
            if (!gone) { if (away) pen.moveTo(...at); else pen.lineTo(...at); }
            away = gone;
          }
        }
        pen.strokeStyle = this.looks[index].colour;
        pen.globalAlpha = chosen === null && this.about.agents > 50 ? 0.25 : 0.7;
        pen.lineWidth = chosen === null ? 1.5 : 3;
        pen.stroke();
        pen.globalAlpha = 1;
      });
    }

    drawRuns(pen) {
      const step = this.step || 1, {agents} = this.about, radius = Math.max(2.5, Math.min(8, this.cell * 0.3));
      const all = this.runs.map((run) => {
        const now = Math.min(step, run.done), chunk = now ? run.chunkAt(now) : null;
        return chunk ? this.place(chunk, (now - chunk.first) * agents) : [];
      });
      if (this.joined.checked) this.drawJoined(pen, all);
      all.forEach((spots, index) => {
        pen.fillStyle = this.looks[index].colour;
        spots.forEach(([x, y]) => { this.mark(pen, index, x, y, radius); pen.fill(); });
        if (this.selected !== null && spots.length) this.ring(pen, spots, radius + 5, this.tones.select, (agent) => agent === this.selected, 3);
      });
      this.spots = all.flat();
    }

    /** Draw lines from an agent's position in the first run to its position in every other run. */
    drawJoined(pen, [first, ...others]) {
      pen.beginPath();
      for (const spots of others) {
        spots.forEach(([x, y], agent) => {
          if (!first[agent] || x < -9999 || first[agent][0] < -9999 || (this.selected !== null && agent !== this.selected)) return;
          pen.moveTo(...first[agent]);
          pen.lineTo(x, y);
        });
      }
      pen.strokeStyle = this.tones.soft;
      pen.globalAlpha = this.about.agents > 100 && this.selected === null ? 0.25 : 0.7;
      pen.lineWidth = 1.2;
      pen.stroke();
      pen.globalAlpha = 1;
    }

    label() { this.canvas.setAttribute("aria-label", `All runs on one map: ${this.names.join(", ")}, step ${this.step || 0}`); }
  }

  /** Return the map of several runs, or null if they differ in world or size. */
  function overlay(runs, options) {
    const size = (run) => [run.about.world, run.about.half_size, run.about.agents].join();
    return runs.every((run) => size(run) === size(runs[0])) ? new Overlay(runs, options) : null;
  }

  /**
   * Return the meaning of every mark that this world has on its maps; with `together`, also of marks for several runs on
   * one map.
   */
  function legend(about, together) {
    const sample = (tone, sign) => h("i", {class: `tone-${tone}`, "aria-hidden": "true"}, sign), fires = (about.fires || []).length;
    const marks = [["agent", "●", "agent, with its number if there is room"], ["bad", "■", "agent whose reply could not be read"], ["mended", "◆", "agent whose reply was repaired"],
      fires ? ["fire", "◯", "inner ring: perceives a fire"] : null, ["talk", "◯", "outer ring: said something"],
      ["select", "◯", "outermost ring: chosen agent"], ["select", "─", "its path; pale: later steps"],
      ["link", "─", "can talk to each other"], ["talk", "─", "a message was delivered"], ["talk", "▬", "a message between sender and recipient"],
      fires ? ["fire", "⬤", "flame: a fire; outline: the area in which agents perceive it, dashed before it starts"] : null,
      about.places.length ? ["place", "▭", "place: number of agents and capacity, also as a bar; red above the capacity"] : null,
      (about.walls || []).length ? ["soft", "■", "wall"] : null, (about.exits || []).length ? ["talk", "■", "exit"] : null,
      (about.zones || []).length ? ["bad", "▒", "zone"] : null, about.food ? ["place", "▒", "food: darker means more"] : null, (about.fires || []).some((fire) => fire.spread) ? ["fire", "▒", "burning cell"] : null];
    const joint = together ? [["ink", "●◆▲", "all on one map: the shape and colour of an agent's marker name its run"], ["soft", "─", "the same agent in two runs"],
      ["ink", "─", "trail, in the run's colour"], ["ink", "▒", "heat map: a darker cell has more visits"]] : [];
    return h("details", {class: "map-legend"}, h("summary", {}, "what the marks mean"),
      h("ul", {class: "legend"}, [...marks.filter(Boolean), ...joint].map(([tone, sign, text]) => h("li", {}, sample(tone, sign), ` ${text}`))));
  }

  /** Return the decision of an agent, in words. */
  function decided(record, kind, about) {
    const said = record.message === null ? "said nothing" : `said “${record.message.length > SHORT ? `${record.message.slice(0, SHORT)}…` : record.message}”`;
    if (kind === "message") return said;
    const inside = ({center, extent}) => Math.abs(record.x_next - center[0]) <= extent[0] && Math.abs(record.y_next - center[1]) <= extent[1];
    const place = record.moved && about.places.find(inside);
    const whom = record.target === null || record.target === undefined ? "" : ` agent ${record.target}`;
    const did = record.action !== "move" ? (record.action === "stay" ? "stayed" : `chose ${record.action}${whom}`)
      : `went ${record.direction}${record.moved ? "" : ", and was stopped"}${place && place.name !== record.place ? ` to ${place.name}` : ""}`;
    return kind === null && record.message !== null ? `${said} and ${did}` : did;
  }

  foundry.gridOverlay = {overlay, legend, decided};
})(window.Foundry);
