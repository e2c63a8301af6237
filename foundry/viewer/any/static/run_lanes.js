"use strict";
/* Loads the decisions of a whole run in blocks of steps, as columns. It keeps nothing else of the run. */
(function (foundry) {
  const FINE = ["chosen", "repaired"];

  class RunLanes {
    constructor(data) {
      this.data = data;
      this.reset();
    }

    reset() {
      this.beginning = this.data.progress.beginning;
      this.blocks = [];
      this.loaded = 0;
      this.kinds = new Set(Object.keys(this.data.about.actions));
      this.utilities = [];
    }

    /** Load the missing blocks. `onBlock` is called after each block. */
    async load(onBlock) {
      if (this.beginning !== this.data.progress.beginning) this.reset();
      const size = this.data.about.marks_per_block, {beginning} = this;
      while (this.loaded < this.data.done) {
        const number = Math.floor(this.loaded / size), block = await this.data.once(`lanes/${number}`);
        if (this.beginning !== beginning || block.last <= this.loaded) return;
        this.blocks[number] = this.indexed(block);
        this.loaded = block.last;
        onBlock();
      }
    }

    indexed(block) {
      block.from = new Map();
      block.step.forEach((step, at) => {
        if (!block.from.has(step)) block.from.set(step, at);
        this.kinds.add(block.kind[at] ?? "");
        if (typeof block.utility[at] === "number") this.addUtility(step, block.utility[at]);
      });
      return block;
    }

    /** Add the utilities of a block. If a longer version of the block comes later, count its utilities again. */
    addUtility(step, value) {
      const known = this.utilities[step - 1];
      if (!known || known.block !== this.loaded) this.utilities[step - 1] = {low: value, high: value, sum: value, count: 1, block: this.loaded};
      else {
        known.low = Math.min(known.low, value);
        known.high = Math.max(known.high, value);
        known.sum += value;
        known.count += 1;
      }
    }

    get hasUtility() { return this.utilities.length > 0; }

    /** Return the kinds of decisions: kinds with actions first, kinds with only messages last. */
    deciding() {
      const declared = Object.keys(this.data.about.actions);
      return [...this.kinds].sort((a, b) => declared.includes(b) - declared.includes(a));
    }

    isUnreadable(block, at) {
      const code = block.outcome[at];
      return code >= 0 && !FINE.includes(this.data.about.outcomes[code]);
    }

    /** Call `visit(block, at)` for every decision of a kind, in one step or in all steps. */
    each(kind, visit, step = null) {
      const blocks = step === null ? this.blocks : [this.blocks[Math.floor((step - 1) / this.data.about.marks_per_block)]];
      for (const block of blocks) {
        if (!block) continue;
        const first = step === null ? 0 : block.from.get(step) ?? block.step.length;
        for (let at = first; at < block.step.length && (step === null || block.step[at] === step); at += 1) {
          if ((block.kind[at] ?? "") === kind) visit(block, at);
        }
      }
    }
  }

  foundry.RunLanes = RunLanes;
})(window.Foundry);
