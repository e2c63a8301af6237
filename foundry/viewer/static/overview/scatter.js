"use strict";
/* Any two measures of the runs against each other; a box drawn around points leaves their runs in the table. */
(function (foundry) {
  const {h, fill, number, color} = foundry.dom, {marks} = foundry;
  const WIDTH = 560, HEIGHT = 320, EDGE = 14;
  const MOVE = 14, LEAST = 4, NEAR = 6;
  /** What an arrow moves of a box: across, up, in parts of the canvas. */
  const ARROWS = {ArrowLeft: [-MOVE, 0], ArrowRight: [MOVE, 0], ArrowUp: [0, -MOVE], ArrowDown: [0, MOVE]};

  class Scatter {
    /**
     * @param onChange called with what the address is to say of the measures and the box, and whether Back is to undo it
     * @param onTick called with the run of a point that is clicked
     */
    constructor(onChange, onTick) {
      this.onChange = onChange;
      this.onTick = onTick;
      this.choice = h("p", {class: "controls"});
      this.canvas = h("canvas", {class: "scatter", width: WIDTH, height: HEIGHT, role: "application", tabindex: "0", "aria-describedby": "scatter-ends"});
      this.ends = h("p", {class: "note", id: "scatter-ends"});
      this.signs = h("p", {class: "note"});
      this.body = h("div", {}, this.choice, this.canvas, this.ends, this.signs);
      this.element = h("details", {class: "scatter-box", hidden: true, ontoggle: () => this.draw()}, h("summary", {}, "two measures against each other"), this.body);
      this.canvas.addEventListener("pointerdown", (event) => { this.from = this.at(event); });
      this.canvas.addEventListener("pointerup", (event) => this.boxed(event));
      this.canvas.addEventListener("keydown", (event) => this.key(event));
    }

    /** Return the range of both measures that a box leaves, or null: x from, to, y from, to. */
    static box(text) {
      const numbers = text.split(",").map(Number);
      return text && numbers.length === 4 && numbers.every(Number.isFinite) ? numbers : null;
    }

    at(event) {
      const {left, top, width, height} = this.canvas.getBoundingClientRect();
      return [((event.clientX - left) / width) * WIDTH, ((event.clientY - top) / height) * HEIGHT];
    }

    boxed(event) {
      if (!this.from || !this.scales) return;
      const to = this.at(event), [a, b] = [this.from[0], to[0]].sort(upwards), [c, d] = [this.from[1], to[1]].sort(upwards);
      this.from = null;
      if (b - a >= LEAST || d - c >= LEAST) this.leave([a, b, c, d]);
      else if (this.nearest(to)) this.onTick(this.nearest(to).row.run);
      else this.onChange({box: null, page: null});
    }

    /** Return the point that is clicked, or undefined; the last one drawn is on top. */
    nearest([x, y]) {
      const {scales} = this;
      return this.points.findLast(({a, b}) => Math.hypot(scales.x.place(a) - x, scales.y.place(b) - y) <= NEAR);
    }

    /** Leave the runs between two places across and two downwards. */
    leave([a, b, c, d], push = true) {
      const {x, y} = this.scales;
      this.onChange({box: [x.value(a), x.value(b), y.value(d), y.value(c)].map((one) => Number(one.toPrecision(6))).join(","), page: null}, push);
    }

    /** Arrows move the box, with Shift its right and upper edges; the first one makes a box in the middle, Escape ends it. */
    key(event) {
      if (!this.scales) return;
      const arrow = ARROWS[event.key], {box} = this.shown;
      if (event.key === "Escape" && box) this.onChange({box: null, page: null});
      else if (arrow) this.leave(box ? moved(this.placesOf(box), arrow, event.shiftKey) : [WIDTH / 4, (3 * WIDTH) / 4, HEIGHT / 4, (3 * HEIGHT) / 4], !box);
      else return;
      event.preventDefault();
    }

    placesOf([a, b, c, d]) {
      const {x, y} = this.scales;
      return [x.place(a), x.place(b), y.place(d), y.place(c)];
    }

    /** @param seen measures, x and y (names), value(name, row), rows, among (a Set of rows that are shown), picked (a Set of ids) */
    show(seen) {
      this.shown = seen;
      this.element.hidden = !seen.measures.length;
      const select = (key) => h("select", {"aria-label": `Measure of the ${key} axis`, onchange: (event) => this.onChange({[key]: event.target.value, box: null, page: null})},
        seen.measures.map((name) => h("option", {value: name, selected: name === seen[key]}, name)));
      fill(this.choice, select("y"), " against ", select("x"), seen.box ? h("button", {type: "button", onclick: () => this.onChange({box: null, page: null})}, "All runs ✕") : null);
      if (seen.box) this.element.open = true;
      this.draw();
    }

    draw() {
      if (!this.shown || !this.element.open) return;
      const {x, y, value, rows, among, picked, models, worlds, box} = this.shown;
      const points = this.points = rows.map((row) => ({row, a: value(x, row), b: value(y, row)})).filter(({a, b}) => a !== null && b !== null);
      this.scales = {x: axis(points.map((one) => one.a), EDGE, WIDTH - EDGE), y: axis(points.map((one) => one.b), HEIGHT - EDGE, EDGE)};
      const looks = foundry.looks.ofModels(models), shapes = marks.shapes(worlds), pen = this.canvas.getContext("2d");
      pen.clearRect(0, 0, WIDTH, HEIGHT);
      for (const {row, a, b} of points) {
        pen.setTransform(1, 0, 0, 1, this.scales.x.place(a), this.scales.y.place(b));
        pen.globalAlpha = among.has(row) ? 0.85 : 0.25;
        pen.fillStyle = looks.get(row.model).colour;
        pen.fill(new Path2D(shapes.get(row.world)));
        pen.strokeStyle = color("ink");
        if (picked.has(row.run)) pen.strokeRect(-8, -8, 16, 16);
      }
      pen.resetTransform();
      pen.globalAlpha = 1;
      if (box) this.drawBox(pen, box);
      const {x: across, y: up} = this.scales;
      this.canvas.setAttribute("aria-label", `${y} against ${x}: ${points.length} runs, ${points.filter((one) => among.has(one.row)).length} of them in the table`);
      this.ends.textContent = `→ ${x}: ${number(across.low)} to ${number(across.high)}; ↑ ${y}: ${number(up.low)} to ${number(up.high)}; a click ticks a run; a box leaves the runs in it in the table: drag one, or use the arrows, with Shift for its size, Esc for none`;
      const sign = (name, shape, colour) => [h("span", {class: "sign"}, marks.sign(shape, colour), ` ${name}`), " "];
      fill(this.signs, models.map((name) => sign(name, shapes.get(worlds[0]), looks.get(name).colour)),
        worlds.length > 1 ? worlds.map((name) => sign(name, shapes.get(name), "currentColor")) : null);
    }

    drawBox(pen, box) {
      const [a, b, c, d] = this.placesOf(box);
      pen.strokeStyle = color("accent");
      pen.strokeRect(a, c, b - a, d - c);
    }
  }

  function upwards(one, other) { return one - other; }

  /** Return a box moved by an arrow, or with its right and upper edges alone moved; it stays on the canvas. */
  function moved([a, b, c, d], [across, down], edges) {
    if (edges) return [a, Math.min(WIDTH, Math.max(a + MOVE, b + across)), Math.max(0, Math.min(d - MOVE, c + down)), d];
    const x = Math.max(-a, Math.min(WIDTH - b, across)), y = Math.max(-c, Math.min(HEIGHT - d, down));
    return [a + x, b + x, c + y, d + y];
  }

  /** Return a linear axis from one place to another; all values alike stand in its middle. */
  function axis(values, from, to) {
    const least = values.reduce((a, b) => Math.min(a, b), Infinity), most = values.reduce((a, b) => Math.max(a, b), -Infinity);
    const [low, high] = most > least ? [least, most] : [least - 1, least + 1];
    return {low: least, high: most, place: (value) => from + ((value - low) / (high - low)) * (to - from), value: (place) => low + ((place - from) / (to - from)) * (high - low)};
  }

  foundry.Scatter = Scatter;
})(window.Foundry);
