"use strict";
/* The colours of actions: one colour per label, one hue for numbers (pale for low numbers), and one colour for unreadable replies. */
(function (foundry) {
  const {color} = foundry.dom, {labels: LABELS, turn: TURN} = foundry.palette;
  const PALE = 0.1;

  function parts(hex) { return [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16)); }

  /** Return a colour of the page as [red, green, blue]. */
  function rgb(text) {
    const pen = document.createElement("canvas").getContext("2d");
    pen.fillStyle = text;
    pen.fillRect(0, 0, 1, 1);
    return [...pen.getImageData(0, 0, 1, 1).data.slice(0, 3)];
  }

  class Colours {
    /** @param declared the actions that the world declares for a kind of decision: `labels`, or `low` and `high`, and `idle`; or null */
    constructor(declared) {
      this.declared = declared || {labels: [], low: null, high: null, idle: null};
      this.labels = new Map();
      this.declared.labels.forEach((label) => this.add(label));
      this.range = [this.declared.low ?? Infinity, this.declared.high ?? -Infinity];
      this.hasNumbers = false;
      this.retone();
    }

    /** Read the colours of the page again, because it may have changed between light and dark. */
    retone() {
      this.bad = rgb(color("bad"));
      this.quiet = rgb(color("line"));
      [this.ground, this.strong] = [rgb(color("panel")), rgb(color("accent"))];
      if (this.labels.has(this.declared.idle)) this.labels.set(this.declared.idle, rgb(color("soft")));
    }

    add(label) {
      const {size} = this.labels;
      this.labels.set(label, size < LABELS.length ? parts(LABELS[size]) : rgb(`hsl(${(size * TURN) % 360} 65% 55%)`));
    }

    /** Add an action. Return whether other actions change their colours because of it. */
    learn(action) {
      if (typeof action === "number") {
        const [low, high] = this.range;
        this.hasNumbers = true;
        this.range = [Math.min(low, action), Math.max(high, action)];
        return this.range[0] !== low || this.range[1] !== high;
      }
      if (action !== null && !this.labels.has(action)) this.add(action);
      return false;
    }

    /** Return the colour of a number by its position in the range, 0 to 1. */
    onScale(share) {
      const strength = PALE + (1 - PALE) * Math.max(0, Math.min(1, share));
      return this.ground.map((part, index) => Math.round(part + (this.strong[index] - part) * strength));
    }

    /** Return the colour of an action as [red, green, blue]. */
    of(action, unreadable) {
      if (unreadable) return this.bad;
      if (action === null) return this.quiet;
      if (typeof action !== "number") return this.labels.get(action);
      const [low, high] = this.range;
      return this.onScale(high > low ? (action - low) / (high - low) : 0.5);
    }
  }

  foundry.Colours = Colours;
})(window.Foundry);
