"use strict";
/* The clock of a page: its position goes from step 1 to the end of the last recorded step. */
(function (foundry) {
  const SPEEDS = [0.5, 1, 2, 4, 8, 16, 30];

  /**
   * Position p means step floor(p), of which the share p - floor(p) has passed: first messages move, then agents.
   * The position after the last step's end is `steps + 1`.
   */
  class Clock {
    constructor() {
      this.position = 1;
      this.steps = 0;
      this.speed = 2;
      this.playing = false;
      this.following = false;
      this.listeners = [];
      this.isReady = () => true;
      this.tick = this.tick.bind(this);
    }

    get end() { return this.steps + 1; }
    get step() { return Math.max(1, Math.min(Math.floor(this.position), this.steps)); }
    get where() { return `${this.steps > 0 && this.position >= this.end ? "after step" : "step"} ${this.step}`; }
    get share() { return Math.min(1, this.position - this.step); }

    onChange(listener) { this.listeners.push(listener); }
    changed() { this.listeners.forEach((listener) => listener(this)); }

    setSteps(steps) {
      const atEnd = this.steps === 0 || this.position >= this.steps;
      this.steps = steps;
      if (this.following && atEnd && !this.playing) this.position = Math.max(1, this.end);
      this.position = Math.min(this.position, Math.max(1, this.end));
      this.changed();
    }

    seek(position) {
      this.position = Math.max(1, Math.min(position, Math.max(1, this.end)));
      this.changed();
    }

    /** Go some steps forward or back, from the beginning of the present step. */
    move(steps) {
      this.pause();
      const whole = Math.floor(this.position);
      this.seek(steps < 0 && this.position > whole ? whole + steps + 1 : whole + steps);
    }

    play() {
      if (this.playing) return;
      if (this.position >= this.end) this.position = 1;
      this.playing = true;
      this.before = null;
      this.changed();
      requestAnimationFrame(this.tick);
    }

    pause() {
      if (!this.playing) return;
      this.playing = false;
      this.changed();
    }

    toggle() { if (this.playing) this.pause(); else this.play(); }

    faster(by) {
      const at = SPEEDS.indexOf(this.speed);
      this.speed = SPEEDS[Math.max(0, Math.min(SPEEDS.length - 1, at + by))];
      this.changed();
    }

    tick(now) {
      if (!this.playing) return;
      const passed = this.before === null ? 0 : Math.min(0.25, (now - this.before) / 1000);
      this.before = now;
      const next = Math.min(this.end, this.position + passed * this.speed);
      if (this.isReady(Math.min(Math.floor(next), this.steps))) this.position = next;
      if (this.position >= this.end && !this.following) this.playing = false;
      this.changed();
      if (this.playing) requestAnimationFrame(this.tick);
    }
  }

  foundry.Clock = Clock;
  foundry.SPEEDS = SPEEDS;
})(window.Foundry);
