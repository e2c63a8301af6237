"use strict";
/* The timeline: a slider over the steps. Above it are events in words, and marks for failures, repairs, messages, and starts of fires. */
(function (foundry) {
  const {h, color, penOf, redrawn} = foundry.dom;
  const HEIGHT = 44, LANE = 18;
  /** Rows of marks from the top: key, colour, form. */
  const ROWS = [
    {key: "undecided", color: "bad", form: "triangle"},
    {key: "repaired", color: "mended", form: "diamond"},
    {key: "boundary", color: "mended", form: "bar"},
    {key: "success", color: "good", form: "bar"},
    {key: "said", color: "talk", form: "amount"},
  ];

  /** Return an event in a few words. */
  function wordsOf({event, agent}) { return `${event.replaceAll("_", " ")}${agent === null ? "" : `, agent ${agent}`}`; }

  /** A canvas with a hand that shows the position of the clock. The drawing does not change while the hand moves. */
  class Dial {
    constructor(canvas, height) {
      Object.assign(this, {canvas, height, width: 0});
      this.hand = h("i", {class: "hand", "aria-hidden": "true", hidden: true});
      this.element = h("div", {class: "dial"}, canvas, this.hand);
    }

    /** Return a context that draws in CSS pixels; null if there is no room. */
    pen() {
      this.width = this.canvas.clientWidth;
      return this.width ? penOf(this.canvas, this.width, this.height) : null;
    }

    point(clock) {
      this.hand.hidden = !clock.steps;
      if (clock.steps) this.hand.style.transform = `translateX(${Math.min(this.width - 2, (clock.position - 1) * this.width / clock.steps)}px)`;
    }
  }

  class Timeline {
    /**
     * @param clock the page's clock
     * @param options.marks returns, for each kind of mark, its numbers by step
     * @param options.fires the fires, each with its start
     * @param options.events returns the events in the order of their steps, each {step, agent, event, text}; optional
     * @param options.agents as for Player; a click on the words of an event chooses its agent
     */
    constructor(clock, options) {
      this.clock = clock;
      this.options = options;
      this.canvas = h("canvas", {class: "marks", "aria-hidden": "true"});
      this.slider = h("input", {
        type: "range", class: "scrub", min: "1", step: "1", "aria-label": "Step",
        oninput: () => { clock.pause(); clock.seek(Number(this.slider.value)); },
      });
      this.lane = options.events ? LANE : 0;
      this.canvas.classList.toggle("with-events", this.lane > 0);
      this.dial = new Dial(this.canvas, HEIGHT + this.lane);
      this.element = h("div", {class: "timeline"}, this.dial.element, this.slider);
      this.written = [];
      this.canvas.addEventListener("pointerdown", (event) => { this.drag(event); this.pick(event); });
      this.canvas.addEventListener("pointermove", (event) => { if (event.buttons) this.drag(event); });
      redrawn(this.canvas, () => this.draw());
      clock.onChange(() => this.update());
    }

    drag(event) {
      this.clock.pause();
      this.clock.seek(1 + Math.floor((event.offsetX / this.canvas.clientWidth) * this.clock.steps));
    }

    /** Choose the agent of the event whose words are pressed. */
    pick({offsetX, offsetY}) {
      const pressed = offsetY < this.lane && this.written.find(({from, to}) => offsetX >= from && offsetX <= to)?.event;
      if (!pressed) return;
      this.clock.seek(Math.max(1, pressed.step));
      if (pressed.agent !== null) this.options.agents?.select(pressed.agent);
    }

    update() {
      const {clock, slider} = this;
      slider.max = String(Math.max(1, clock.end));
      slider.value = String(Math.floor(clock.position));
      slider.setAttribute("aria-valuetext", `${clock.where} of ${clock.steps}`);
      if (clock.steps === this.drawn) this.dial.point(clock); else this.draw();
    }

    draw() {
      const {clock} = this, pen = this.dial.pen();
      if (!pen) return;
      this.drawn = clock.steps;
      const per = this.dial.width / Math.max(1, clock.steps);
      this.drawFires(pen, per);
      const marks = this.options.marks();
      const rows = ROWS.filter((row) => marks[row.key]);
      rows.forEach((row, index) => this.drawRow(pen, row, marks[row.key], per, this.lane + (index * HEIGHT) / rows.length, HEIGHT / rows.length));
      if (this.lane) this.drawEvents(pen, per);
      this.dial.point(clock);
    }

    drawFires(pen, per) {
      pen.fillStyle = color("fire");
      for (const fire of this.options.fires || []) {
        if (fire.start > this.clock.steps) continue;
        pen.globalAlpha = 0.18;
        pen.fillRect((fire.start - 1) * per, this.lane, 4000, HEIGHT);
        pen.globalAlpha = 1;
        pen.fillRect((fire.start - 1) * per, this.lane, 2, HEIGHT);
      }
    }

    /** Draw a tick at every event, and its words if there is room; the rarest events come first. */
    drawEvents(pen, per) {
      const counts = new Map(), events = this.options.events();
      this.written = [];
      events.forEach(({event}) => counts.set(event, (counts.get(event) || 0) + 1));
      pen.font = "11px system-ui, sans-serif";
      pen.textBaseline = "middle";
      for (const event of [...events].sort((a, b) => counts.get(a.event) - counts.get(b.event) || a.step - b.step)) {
        const left = Math.max(0, event.step - 1) * per, words = wordsOf(event), right = left + 6 + pen.measureText(words).width;
        const hasRoom = right < this.dial.width && this.written.every(({from, to}) => left >= to || right <= from);
        pen.fillStyle = color(hasRoom ? "ink" : "soft");
        pen.fillRect(left, hasRoom ? 2 : LANE - 4, 2, hasRoom ? LANE - 2 : 4);
        if (!hasRoom) continue;
        this.written.push({from: left, to: right + 6, event});
        pen.fillText(words, left + 5, LANE / 2);
      }
    }

    drawRow(pen, row, values, per, top, height) {
      const most = Math.max(1, ...values);
      pen.fillStyle = color(row.color);
      values.forEach((value, index) => {
        if (!value) return;
        const left = index * per, middle = left + per / 2, size = Math.min(height, 10) / 2;
        if (row.form === "amount") {
          const tall = Math.max(2, (value / most) * (height - 2));
          pen.fillRect(left, top + height - tall, Math.max(1, per - 1), tall);
        } else if (row.form === "bar" || per < 4) {
          pen.fillRect(left, top + 2, Math.max(1.5, per - 1), height - 4);
        } else {
          this.drawSign(pen, row.form, middle, top + height / 2, size);
        }
      });
    }

    drawSign(pen, form, x, y, size) {
      pen.beginPath();
      pen.moveTo(x - size, form === "diamond" ? y : y - size);
      pen.lineTo(form === "diamond" ? x : x + size, y - size);
      if (form === "diamond") pen.lineTo(x + size, y);
      pen.lineTo(x, y + size);
      pen.fill();
    }

    /** Return the next step in a direction with a mark of one of these kinds; null if there is none. */
    next(kinds, direction) {
      const marks = this.options.marks();
      const has = (step) => kinds.some((kind) => (marks[kind] || [])[step - 1] > 0);
      for (let step = this.clock.step + direction; step >= 1 && step <= this.clock.steps; step += direction) {
        if (has(step)) return step;
      }
      return null;
    }

    /** Return the next step in a direction with an event; null if there is none. */
    nextEvent(direction) {
      const steps = this.options.events().map(({step}) => Math.max(1, step)).filter((step) => (step - this.clock.step) * direction > 0);
      return steps.length ? steps[direction > 0 ? 0 : steps.length - 1] : null;
    }

    nextFire(direction) {
      const starts = (this.options.fires || []).map((fire) => fire.start).filter((start) => start <= this.clock.steps);
      const ahead = starts.filter((start) => (start - this.clock.step) * direction > 0);
      if (!ahead.length) return null;
      return direction > 0 ? Math.min(...ahead) : Math.max(...ahead);
    }
  }

  foundry.Timeline = Timeline;
  foundry.Dial = Dial;
})(window.Foundry);
