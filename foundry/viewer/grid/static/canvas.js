"use strict";
/* Draws one step of a 2D run on a canvas: agents, links and moving messages, on the ground of `ground.js`. */
(function (foundry) {
  const {h, color, penOf} = foundry.dom;
  const SAID = 1, ALARMED = 4, AWAY = 8;
  const NOWHERE = [-99999, -99999];
  const FLIGHT = 0.45;
  const MOST_ZOOM = 20;
  /** Radius of an agent, px: the usual one, the smallest in a crowd, and the smallest at which its number is readable. */
  const LARGE = 9, SMALL = 2.5, READABLE = 6.5;
  /** Least distance between the edge of the canvas and the centre of an agent in the outermost cell, px: an agent and its ring. */
  const MARGIN = 16;
  /** Largest number of texts on the map, and of characters of a text. */
  const BUBBLES = 5, SIGNS = 42;
  const TAU = 2 * Math.PI;
  const TONES = ["ink", "soft", "line", "paper", "agent", "bad", "mended", "talk", "fire", "place", "link", "select"];

  class Grid extends foundry.GridGround {
    /**
     * @param data the RunData
     * @param options.onPick called with the agent that the user clicked, or null
     * @param options.onCamera called with the value of `camera` when the visible part changes
     */
    constructor(data, options = {}) {
      super();
      this.data = data;
      this.about = data.about;
      this.options = options;
      this.selected = null;
      this.track = null;
      this.zoom = 1;
      this.centre = [0, 0];
      this.canvas = h("canvas", {class: "grid", role: "img", tabindex: "0", "aria-label": "The grid"});
      this.element = h("div", {class: "grid-box"}, this.canvas, h("div", {class: "zoom"},
        this.zoomButton("+", "Zoom in", 1.5), this.zoomButton("−", "Zoom out", 1 / 1.5), this.zoomButton("⤢", "Whole grid", 0)));
      foundry.gestures(this.canvas, {zoomAt: (...at) => this.zoomAt(...at), shift: (...by) => this.shift(...by), pick: (...at) => this.pick(...at), isWhole: () => this.zoom === 1});
      this.canvas.addEventListener("pointermove", ({offsetX, offsetY}) => this.hover(offsetX, offsetY));
      this.canvas.addEventListener("pointerleave", () => this.hover(-LARGE, -LARGE));
      this.still = window.matchMedia("(prefers-reduced-motion: reduce)");
      window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { this.tones = null; this.redraw(); });
      new ResizeObserver(() => this.redraw()).observe(this.element);
    }

    zoomButton(sign, label, factor) {
      return h("button", {type: "button", "aria-label": label, title: label, onclick: () => this.zoomBy(factor)}, sign);
    }

    /** Zoom around the centre; 0 shows the whole grid. */
    zoomBy(factor) { this.zoomAt(factor, this.width / 2, this.height / 2); }

    /** Zoom around a point, in pixels. */
    zoomAt(factor, px, py) {
      const zoom = Math.max(1, Math.min(MOST_ZOOM, this.zoom * factor)), grown = zoom / this.zoom;
      const x = this.centre[0] + (px - this.width / 2) / this.cell, y = this.centre[1] - (py - this.height / 2) / this.cell;
      this.centre = zoom === 1 ? [0, 0] : [x + (this.centre[0] - x) / grown, y + (this.centre[1] - y) / grown];
      this.zoom = zoom;
      this.moved();
    }

    shift(dx, dy) {
      this.centre = [this.centre[0] - dx / this.cell, this.centre[1] + dy / this.cell];
      this.moved();
    }

    /** Return the visible part as a text for the address: zoom and centre; null for the whole grid. */
    get camera() {
      return this.zoom === 1 && !this.centre.some(Boolean) ? null : [this.zoom, ...this.centre].map((n) => Number(n.toFixed(2))).join(",");
    }

    set camera(text) {
      const [zoom, x, y] = (text || "").split(",").map(Number);
      if (!(zoom >= 1 && zoom <= MOST_ZOOM && Number.isFinite(x) && Number.isFinite(y))) return;
      Object.assign(this, {zoom, centre: [x, y]});
      this.redraw();
    }

    moved() {
      this.redraw();
      if (this.options.onCamera) this.options.onCamera(this.camera);
    }

    /** Return the agent at a point, in pixels, or null. */
    under(px, py) {
      let best = null, nearest = Math.max(10, this.cell) ** 2;
      (this.spots || []).forEach(([x, y], agent) => {
        const away = (x - px) ** 2 + (y - py) ** 2;
        if (away < nearest) { nearest = away; best = agent; }
      });
      return best;
    }

    pick(px, py) { if (this.options.onPick) this.options.onPick(this.under(px, py)); }

    /** Write the number of the agent under the pointer, even in a crowd. */
    hover(px, py) {
      const agent = this.under(px, py);
      if (agent === this.hovered) return;
      this.hovered = agent;
      this.canvas.title = agent === null ? "" : `agent ${agent}`;
      this.redraw();
    }

    select(agent) { this.selected = agent; }

    /** Describe the picture to users of screen readers. */
    label(name) { this.canvas.setAttribute("aria-label", name ? `${name}. ${this.describe()}` : this.describe()); }

    toX(x) { return this.width / 2 + (x - this.centre[0]) * this.cell; }
    toY(y) { return this.height / 2 - (y - this.centre[1]) * this.cell; }

    /**
     * Draw a step, of which the given share has passed. Return whether its records are loaded; until then, the last
     * picture stays, in pale colours.
     */
    draw(step, share) {
      const chunk = step ? this.data.chunkAt(step) : null;
      this.element.classList.toggle("waits", step > 0 && chunk === null);
      if (chunk || !this.chunk) Object.assign(this, {step, share, chunk});
      this.redraw();
      if (chunk && this.texts !== step) {
        Object.assign(this, {texts: step, spoken: new Map()});
        this.data.said(step).then((spoken) => { if (this.texts === step) { this.spoken = spoken; this.redraw(); } }, () => null);
      }
      this.data.prefetch(step);
      return chunk !== null;
    }

    measure() {
      const {canvas, element, about} = this, width = element.clientWidth, height = element.clientHeight;
      canvas.classList.toggle("in-part", this.zoom > 1);
      this.width = width;
      this.height = height;
      const side = Math.min(width, height), {half_size: half} = about;
      this.cell = Math.min(side / (2 * half + 2), (side - 2 * MARGIN) / (2 * half)) * this.zoom;
      return penOf(canvas, width, height);
    }

    retone() { if (!this.tones) this.tones = Object.fromEntries(TONES.map((name) => [name, color(name)])); }

    redraw() {
      if (!this.element.clientWidth) return;
      this.retone();
      const pen = this.measure();
      pen.fillStyle = this.tones.paper;
      pen.fillRect(0, 0, this.width, this.height);
      this.drawField(pen);
      const {chunk, step} = this;
      this.drawChanging(pen);
      this.drawFurniture(pen);
      if (!chunk || step < chunk.first || step > chunk.last) { this.drawFires(pen); this.drawLabels(pen); return; }
      const base = (step - chunk.first) * this.about.agents;
      this.drawPlaces(pen, chunk, base);
      this.drawFires(pen);
      const at = this.place(chunk, base);
      this.drawLinks(pen, chunk.links[step - chunk.first], at);
      this.drawTrack(pen);
      this.drawTails(pen, chunk, base, at);
      const deliveries = this.share < FLIGHT ? chunk.deliveries[step - chunk.first] : [];
      if (this.share === 0) this.drawDelivered(pen, deliveries, at);
      this.drawAgents(pen, chunk, base, at);
      if (this.share > 0) this.drawFlying(pen, deliveries, at, this.still.matches ? 0.5 : this.share / FLIGHT);
      this.drawLabels(pen);
      if (this.share < FLIGHT) this.drawBubbles(pen, at, deliveries);
    }

    /** Return the position of each agent on the canvas, in pixels. Agents in the same cell are placed around its centre. */
    place(chunk, base) {
      const {about} = this, count = about.agents, share = this.still.matches ? Math.floor(this.share) : this.share;
      const moved = Math.max(0, Math.min(1, (share - FLIGHT) / (1 - FLIGHT)));
      const crowd = new Map(), spots = new Array(count), room = Math.sqrt((this.cell * (2 * about.half_size + 1)) ** 2 / count);
      const wide = Math.max(1, Math.round(2 * LARGE / this.cell)), keyOf = (at) => chunk.x[at] * 100003 + chunk.y[at];
      const areaOf = (at) => Math.floor(chunk.x[at] / wide) * 100003 + Math.floor(chunk.y[at] / wide);
      for (let agent = base; agent < base + count; agent += 1) if (!(chunk.flags[agent] & AWAY)) crowd.set(areaOf(agent), (crowd.get(areaOf(agent)) || 0) + 1);
      const largest = Math.max(SMALL, Math.min(LARGE, 0.12 * room)), placed = new Map();
      this.radii = Array.from({length: count}, (_, agent) => Math.max(SMALL, largest / (crowd.get(areaOf(base + agent)) || 1) ** 0.25));
      for (let agent = 0; agent < count; agent += 1) {
        const now = base + agent, next = now + count;
        if (chunk.flags[now] & AWAY) { spots[agent] = NOWHERE; continue; }
        const x = chunk.x[now] + (chunk.x[next] - chunk.x[now]) * moved, y = chunk.y[now] + (chunk.y[next] - chunk.y[now]) * moved;
        const before = placed.get(keyOf(now)) || 0;
        placed.set(keyOf(now), before + 1);
        const turn = before * 2.4, away = this.radii[agent] * 1.5 * Math.sqrt(before);
        spots[agent] = [this.toX(x) + Math.cos(turn) * away, this.toY(y) + Math.sin(turn) * away];
      }
      this.spots = spots;
      return spots;
    }

    drawLinks(pen, links, at) {
      pen.beginPath();
      for (let index = 0; index < links.length; index += 2) {
        const a = at[links[index]], b = at[links[index + 1]];
        pen.moveTo(a[0], a[1]);
        pen.lineTo(b[0], b[1]);
      }
      pen.strokeStyle = this.tones.link;
      pen.globalAlpha = links.length > 2000 ? 0.25 : 0.6;
      pen.lineWidth = 1;
      pen.stroke();
      pen.globalAlpha = 1;
    }

    drawTrack(pen) {
      if (!this.track || this.selected === null) return;
      const {x, y} = this.track;
      const upTo = Math.min(this.share < 1 ? this.step - 1 : this.step, x.length - 1);
      for (const [from, to, alpha] of [[0, x.length - 1, 0.25], [0, upTo, 0.9]]) {
        pen.beginPath();
        for (let index = from; index <= to; index += 1) pen.lineTo(this.toX(x[index]), this.toY(y[index]));
        pen.globalAlpha = alpha;
        pen.strokeStyle = this.tones.select;
        pen.lineWidth = 2;
        pen.stroke();
      }
      pen.globalAlpha = 1;
    }

    drawAgents(pen, chunk, base, at) {
      const {tones, about, radii} = this, names = about.outcomes;
      const groups = new Map();
      for (let agent = 0; agent < about.agents; agent += 1) {
        const outcome = names[chunk.outcome[base + agent]], message = names[chunk.message_outcome[base + agent]];
        const tone = this.tone(outcome, message);
        if (!groups.has(tone)) groups.set(tone, []);
        groups.get(tone).push(agent);
      }
      for (const [tone, agents] of groups) this.drawBodies(pen, agents, at, tones[tone], tone);
      const near = Math.max(0.6, Math.min(1, Math.max(...radii) / 6)); // small agents have small rings, so that the agents of a crowd stay distinguishable
      this.ring(pen, at, 2.5 * near, tones.fire, (agent) => chunk.flags[base + agent] & ALARMED, 2 * near);
      this.ring(pen, at, 6 * near, tones.talk, (agent) => this.share < FLIGHT && chunk.flags[base + agent] & SAID, 2 * near);
      if (this.selected !== null && this.selected < about.agents) this.ring(pen, at, 9, tones.select, (agent) => agent === this.selected, 3);
      this.drawNumbers(pen, at);
    }

    tone(outcome, message) {
      const both = [outcome, message];
      if (both.some((name) => name !== "chosen" && name !== "repaired")) return "bad";
      return both.includes("repaired") ? "mended" : "agent";
    }

    /** Draw agents as discs. Agents with an unreadable reply are squares, and agents with a repaired reply are diamonds. */
    drawBodies(pen, agents, at, tone, name) {
      pen.beginPath();
      for (const agent of agents) {
        const [x, y] = at[agent], radius = this.radii[agent];
        if (name === "bad") pen.rect(x - radius, y - radius, 2 * radius, 2 * radius);
        else if (name === "mended") this.diamond(pen, x, y, radius * 1.25);
        else { pen.moveTo(x + radius, y); pen.arc(x, y, radius, 0, TAU); }
      }
      pen.fillStyle = tone;
      pen.fill();
    }

    diamond(pen, x, y, size) {
      pen.moveTo(x, y - size);
      pen.lineTo(x + size, y);
      pen.lineTo(x, y + size);
      pen.lineTo(x - size, y);
      pen.closePath();
    }

    ring(pen, at, beyond, tone, belongs, width) {
      pen.beginPath();
      at.forEach(([x, y], agent) => {
        if (!belongs(agent)) return;
        const radius = this.radii[agent] + beyond;
        pen.moveTo(x + radius, y);
        pen.arc(x, y, radius, 0, TAU);
      });
      pen.strokeStyle = tone;
      pen.lineWidth = width;
      pen.stroke();
    }

    /** Write the numbers of agents that are large enough, and of the agent under the pointer. */
    drawNumbers(pen, at) {
      const {tones, hovered, radii} = this;
      pen.font = `600 11px system-ui, sans-serif`;
      pen.textAlign = "center";
      pen.textBaseline = "middle";
      pen.fillStyle = tones.paper;
      at.forEach(([x, y], agent) => { if (radii[agent] >= READABLE) pen.fillText(String(agent), x, y + 0.5); });
      if (hovered !== null && hovered !== undefined && radii[hovered] < READABLE) {
        const [x, y] = at[hovered];
        pen.beginPath();
        pen.arc(x, y, LARGE, 0, TAU);
        pen.fillStyle = tones.agent;
        pen.fill();
        pen.fillStyle = tones.paper;
        pen.fillText(String(hovered), x, y + 0.5);
      }
      pen.textAlign = "start";
      pen.textBaseline = "alphabetic";
    }

    /** Draw a line from the position of each agent before its last move. */
    drawTails(pen, chunk, base, at) {
      const {about, step, share} = this, before = share > FLIGHT ? chunk : this.data.chunkAt(Math.max(1, step - 1));
      if (!before) return;
      const from = share > FLIGHT ? base : (Math.max(1, step - 1) - before.first) * about.agents;
      pen.beginPath();
      at.forEach(([x, y], agent) => {
        const [tailX, tailY] = [this.toX(before.x[from + agent]), this.toY(before.y[from + agent])];
        const [nowX, nowY] = [chunk.x[base + agent], chunk.y[base + agent]];
        if (x < NOWHERE[0] / 2 || (share <= FLIGHT && before.x[from + agent] === nowX && before.y[from + agent] === nowY)) return;
        pen.moveTo(tailX, tailY);
        pen.lineTo(x, y);
      });
      pen.strokeStyle = this.tones.agent;
      pen.globalAlpha = 0.55;
      pen.lineWidth = 3;
      pen.stroke();
      pen.globalAlpha = 1;
    }

    /**
     * Write messages into bubbles: first of the chosen agent, then of the agents with the most hearers. Bubbles never
     * overlap.
     */
    drawBubbles(pen, at, deliveries) {
      const heard = new Map(), {tones, selected} = this, taken = [];
      for (let index = 0; index < deliveries.length; index += 2) heard.set(deliveries[index], (heard.get(deliveries[index]) || 0) + 1);
      const order = [...this.spoken || []].sort(([a], [b]) => (b === selected) - (a === selected) || (heard.get(b) || 0) - (heard.get(a) || 0) || a - b);
      pen.font = "11px system-ui, sans-serif";
      for (const [agent, text] of order) {
        if (taken.length === BUBBLES) return;
        const words = text.length > SIGNS ? `${text.slice(0, SIGNS)}…` : text, [x, y] = at[agent], away = this.radii[agent] + 8, width = pen.measureText(words).width + 10;
        const left = Math.max(2, Math.min(this.width - width - 2, x + 6)), top = y - away - 18 > 2 ? y - away - 18 : y + away;
        const box = {left, top, right: left + width, bottom: top + 18};
        if (x < 0 || y < 0 || x > this.width || y > this.height || taken.some((other) => box.left < other.right && box.right > other.left && box.top < other.bottom && box.bottom > other.top)) continue;
        taken.push(box);
        pen.beginPath();
        pen.moveTo(x, y);
        pen.lineTo(x + 8, top < y ? top + 18 : top);
        pen.roundRect(left, top, width, 18, 5);
        pen.fillStyle = tones.paper;
        pen.fill();
        pen.strokeStyle = tones.talk;
        pen.lineWidth = 1.2;
        pen.stroke();
        pen.fillStyle = tones.ink;
        pen.fillText(words, left + 5, top + 13);
      }
    }

    /** Draw the links between senders and hearers, below the moving messages. */
    drawDelivered(pen, deliveries, at) {
      pen.beginPath();
      for (let index = 0; index < deliveries.length; index += 2) {
        pen.moveTo(...at[deliveries[index]]);
        pen.lineTo(...at[deliveries[index + 1]]);
      }
      pen.strokeStyle = this.tones.talk;
      pen.lineWidth = 1.5;
      pen.globalAlpha = deliveries.length > 4000 ? 0.35 : 0.9;
      pen.stroke();
      pen.globalAlpha = 1;
    }

    /** Draw the messages at the given share of their way. */
    drawFlying(pen, deliveries, at, way) {
      pen.beginPath();
      for (let index = 0; index < deliveries.length; index += 2) {
        const a = at[deliveries[index]], b = at[deliveries[index + 1]];
        pen.rect(a[0] + (b[0] - a[0]) * way - 3, a[1] + (b[1] - a[1]) * way - 2, 6, 4);
      }
      pen.fillStyle = this.tones.talk;
      pen.fill();
    }

    /** Return a description of the picture in words. */
    describe() {
      const {about, chunk, step} = this;
      if (!chunk || step < chunk.first || step > chunk.last) return "No records of this step yet.";
      const inside = this.countInside(chunk, (step - chunk.first) * about.agents);
      const places = about.places.map((place, index) => `${inside[index]} in ${place.name} (capacity ${place.capacity})`);
      const burning = (about.fires || []).filter((fire) => fire.start <= step).map((fire) => fire.name);
      const delivered = chunk.deliveries[step - chunk.first].length / 2;
      const base = (step - chunk.first) * about.agents;
      const there = chunk.flags.subarray(base, base + about.agents).filter((flags) => !(flags & AWAY)).length;
      const where = places.length ? `: ${places.join(", ")}` : "";
      return `${there} agents${where}. ${delivered} messages delivered. ${burning.length ? `Burning: ${burning.join(", ")}.` : "No fire."}`;
    }
  }

  Grid.KEYS = [["Tab to the map, ← → ↑ ↓", "move the map after zooming in"]];
  foundry.Grid = Grid;
})(window.Foundry);
