"use strict";
/* Draws the routes of all compared 3D runs on one plan from above: each agent's position at the step, its direction, and whether it could see its target. */
(function (foundry) {
  const {h, color, number, penOf} = foundry.dom;
  const LEAST = 220, MOST = 520, INSET = 26, ROOM_M = 0.6, GAZE = 20, RADIUS = 7, NARROW = 600, TAU = 2 * Math.PI;
  const SAMPLE = {width: 44, height: 16};

  class Ways {
    constructor(runs, {names, looks}) {
      Object.assign(this, {runs, names, looks, poses: runs.map(() => []), targets: [], walls: [], bounds: null, begun: 0, step: 0, share: 0});
      this.canvas = h("canvas", {class: "ways", role: "img"});
      this.said = names.map(() => h("span", {class: "note"}));
      this.why = h("p", {class: "note", hidden: true});
      const entry = (name, index) => h("li", {}, foundry.looks.line(looks[index], {...SAMPLE, radius: RADIUS}), " ", h("b", {}, h("bdi", {}, name)), " ", this.said[index]);
      this.title = runs.length > 1 ? "All routes from above" : "The route from above";
      const marks = h("ul", {class: "legend"}, this.legend());
      this.box = h("section", {class: "overlay", "aria-label": this.title}, h("h2", {}, this.title), this.canvas, this.why,
        h("ul", {class: "legend runs-legend"}, names.map(entry)), runs.length > 1 ? marks : h("details", {}, h("summary", {}, "what the marks mean"), marks));
      window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.redraw());
      new ResizeObserver(() => this.redraw()).observe(this.box);
    }

    legend() {
      const entry = (draw, text) => {
        const canvas = h("canvas", {class: "sample", "aria-hidden": "true", ...SAMPLE}), pen = canvas.getContext("2d");
        pen.strokeStyle = pen.fillStyle = "#808080";
        draw(pen);
        return h("li", {}, canvas, ` ${text}`);
      };
      return [
        entry((pen) => { pen.arc(22, 8, RADIUS - 1, 0, TAU); pen.lineWidth = 2; pen.stroke(); }, "start"),
        entry((pen) => { this.line(pen, [[18, 8], [40, 8]], {width: 2.5}); this.mark(pen, this.looks[0].marker, 18, 8); }, "position and direction of view"),
        entry((pen) => { pen.globalAlpha = 0.4; this.line(pen, [[2, 8], [42, 8]], {width: 2}); }, "pale: later steps"),
        entry((pen) => this.target(pen, [[8, 3], [36, 13]]), "the target"),
        entry((pen) => this.line(pen, [[2, 8], [42, 8]], {width: 1}), "thin: line of sight to the target; broken if something is in between"),
        entry((pen) => this.line(pen, [[2, 8], [42, 8]], {width: 1.5, dash: [1, 3]}), "dotted: the shortest route"),
      ];
    }

    /** Load the data that never change: the plan of the common scene, and the targets. */
    async loadScene() {
      const begun = this.runs.filter((run) => run.done);
      await Promise.all(begun.map(foundry.camera.begin));
      if (new Set(begun.map((run) => run.about.episode.scene_sha256)).size > 1) this.explain("The runs are in several scenes, so no walls are drawn.");
      else {
        const {walls, why} = await begun[0].once("plan");
        this.walls = walls;
        this.redraw();
        if (why) this.explain(`No walls are drawn: ${why}`);
      }
      const sights = await Promise.all(this.runs.map((run) => run.once("sights/0")));
      this.targets = sights.map(({target}) => target);
      this.bound();
      this.redraw();
    }

    explain(text) {
      this.why.hidden = false;
      this.why.textContent = text;
    }

    /** Load the missing poses. */
    async load() {
      if (this.loading) return;
      this.loading = true;
      try {
        await Promise.all(this.runs.map((run, index) => this.loadRun(run, this.poses[index])));
      } finally {
        this.loading = false;
      }
      this.redraw();
    }

    async loadRun(run, poses) {
      while (poses.length <= run.done && run.done) {
        const chunk = await run.load(Math.max(1, poses.length)), before = poses.length;
        chunk.steps.forEach((row) => {
          poses[row.step - 1] = row.pose;
          poses[row.step] = row.pose_next;
        });
        this.bound();
        if (poses.length === before) return;
      }
    }

    /** Find the range of routes and targets, metres: left and right, bottom and top. */
    bound() {
      const places = [...this.poses.flat().map(({x, y}) => [x, y]), ...this.targets.flatMap((target) => (target ? target.boxes.flat() : []))];
      const reach = (key) => places.reduce(([low, high], place) => [Math.min(low, place[key] - ROOM_M), Math.max(high, place[key] + ROOM_M)], [Infinity, -Infinity]);
      this.bounds = places.length ? [reach(0), reach(1)] : null;
    }

    draw(step, share) {
      Object.assign(this, {step, share});
      const begun = this.runs.filter((run) => run.done).length;
      if (begun !== this.begun) {
        this.begun = begun;
        this.loadScene().catch((error) => this.explain(error.message));
      }
      if (this.runs.some((run, index) => this.poses[index].length <= run.done)) this.load().catch((error) => this.explain(error.message));
      this.redraw();
    }

    select() {}

    label() { this.canvas.setAttribute("aria-label", `${this.title}, step ${this.step}: ${this.names.map((name, index) => `${name} ${this.said[index].textContent}`).join("; ")}`); }

    /** Return the record whose picture is visible now; null after the end of a run, or until the record is loaded. */
    record(index) {
      const chunk = this.step <= this.runs[index].done ? this.runs[index].chunkAt(this.step) : null;
      return chunk && this.share < 1 ? chunk.steps[this.step - chunk.first] : null;
    }

    redraw() {
      const {canvas, bounds} = this, width = canvas.clientWidth;
      if (!width || !bounds) return;
      const [[left, right], [low, high]] = bounds;
      const metre = Math.min((width - 2 * INSET) / (right - left), (MOST - 2 * INSET) / (high - low)), height = Math.max(LEAST, (high - low) * metre + 2 * INSET);
      this.at = ([x, y]) => [width / 2 + (x - (left + right) / 2) * metre, height / 2 - (y - (low + high) / 2) * metre];
      canvas.style.height = `${Math.round(height)}px`;
      const pen = penOf(canvas, width, height);
      this.drawScene(pen, this.at);
      this.poses.forEach((poses, index) => poses.length && this.way(pen, poses, index, ({x, y}) => this.at([x, y])));
      this.ruler(pen, metre, height);
      this.poses.forEach((poses, index) => { this.said[index].textContent = this.tell(poses, index); });
    }

    drawScene(pen, at) {
      pen.strokeStyle = color("soft");
      pen.globalAlpha = 0.55;
      pen.lineWidth = 1;
      pen.beginPath();
      for (const [start, end] of this.walls) {
        pen.moveTo(...at(start));
        pen.lineTo(...at(end));
      }
      pen.stroke();
      pen.globalAlpha = 1;
      pen.strokeStyle = pen.fillStyle = color("ink");
      const drawn = new Set();
      this.runs.forEach(({about: {episode}}, index) => {
        const shortest = (episode?.shortest_path || []).map(at), target = this.targets[index], name = episode?.target;
        if (!drawn.has(shortest.join())) this.line(pen, shortest, {width: 1.5, dash: [1, 4]});
        if (target && !drawn.has(name)) {
          target.boxes.forEach((box) => this.target(pen, box.map(at)));
          const [x, y] = at(target.middle);
          this.write(pen, name, x, y - 10);
        }
        drawn.add(name).add(shortest.join());
      });
    }

    write(pen, text, x, y) {
      pen.font = "600 12px system-ui, sans-serif";
      const wide = pen.measureText(text).width, left = Math.max(2, Math.min(x - wide / 2, this.canvas.clientWidth - wide - 2));
      pen.fillText(text, left, Math.max(12, y));
    }

    target(pen, [[left, low], [right, high]]) {
      const wide = Math.max(4, Math.abs(right - left)), tall = Math.max(4, Math.abs(high - low));
      const box = [(left + right - wide) / 2, (low + high - tall) / 2, wide, tall], {globalAlpha} = pen;
      pen.lineWidth = 2;
      pen.strokeRect(...box);
      pen.globalAlpha = 0.25;
      pen.fillRect(...box);
      pen.globalAlpha = globalAlpha;
    }

    line(pen, places, {width, dash = []}) {
      pen.setLineDash(dash);
      pen.lineWidth = width;
      pen.beginPath();
      places.forEach((place) => pen.lineTo(...place));
      pen.stroke();
      pen.setLineDash([]);
    }

    mark(pen, marker, x, y, radius = RADIUS) {
      foundry.looks.trace(pen, marker, x, y, radius);
      pen.fill();
    }

    now(poses) { return poses[Math.max(0, Math.min(poses.length - 1, this.share < 1 ? this.step - 1 : this.step))]; }

    tell(poses, index) {
      if (!poses.length) return "no record";
      const {x, y} = this.now(poses), record = this.record(index), name = this.runs[index].about.episode?.target;
      const sees = record && name ? `, ${record.line_of_sight ? "in line of sight of" : "no line of sight to"} ${name}` : "";
      return `x ${number(x)} m, y ${number(y)} m${sees}`;
    }

    /**
     * Draw a route: pale for later steps, strong for past steps. A ring marks the start, and a marker with a stroke the
     * present position and direction.
     */
    way(pen, poses, index, at) {
      const look = this.looks[index], size = this.canvas.clientWidth < NARROW ? 0.7 : 1, gone = poses.indexOf(this.now(poses)), [x, y] = at(poses[gone]), turn = poses[gone].yaw * TAU / 360;
      pen.strokeStyle = pen.fillStyle = look.colour;
      for (const [upTo, alpha, width] of [[poses.length - 1, 0.35, 1.5], [gone, 1, 2.5]]) {
        pen.globalAlpha = alpha;
        this.line(pen, poses.slice(0, upTo + 1).map(at), {width, dash: foundry.looks.broken(look, width)});
      }
      pen.lineWidth = 2;
      pen.beginPath();
      pen.arc(...at(poses[0]), size * RADIUS, 0, TAU);
      pen.stroke();
      const record = this.record(index), target = this.targets[index];
      if (record && target) this.line(pen, [[x, y], at({x: target.middle[0], y: target.middle[1]})], {width: 1, dash: record.line_of_sight ? [] : [4, 5]});
      this.line(pen, [[x, y], [x + size * GAZE * Math.cos(turn), y - size * GAZE * Math.sin(turn)]], {width: 3});
      this.mark(pen, look.marker, x, y, size * RADIUS);
    }

    ruler(pen, metre, height) {
      pen.fillStyle = color("soft");
      pen.fillRect(INSET, height - 12, metre, 2);
      pen.font = "11px system-ui, sans-serif";
      pen.fillText("1 m", INSET, height - 16);
    }
  }

  foundry.Ways = Ways;
})(window.Foundry);
