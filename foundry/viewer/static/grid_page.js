"use strict";
/* The page of a 2D run: grid, timeline, agent, search. */
(function (foundry) {
  const {h} = foundry.dom;
  const SAID = 1;

  class GridPage {
    constructor(data, wanted) {
      this.data = data;
      this.agent = null;
      this.grid = new foundry.Grid(data, {onPick: (agent) => this.select(agent)});
      this.inspector = new foundry.Inspector(data, (agent) => this.select(agent));
      this.player = new foundry.Player({
        marks: () => this.ownMarks || data.marks, fires: data.about.fires, kinds: ["message", "fire", "failure"],
        summary: () => this.grid.describe(), onKey: (key) => this.key(key),
      });
      this.search = new foundry.Search(data, "Search in messages", (step, agent) => { this.select(agent); this.clock.pause(); this.clock.seek(step); });
      this.clock = this.player.clock;
      this.clock.isReady = (step) => data.chunkAt(step) !== null;
      this.clock.onChange(() => this.update());
      this.state = h("span", {class: "state"});
      this.element = h("div", {class: "run"},
        foundry.runHeading(data, this.state), this.player.element,
        h("div", {class: "stage"}, this.grid.element, h("div", {class: "side"}, this.inspector.element, this.search.element)));
      data.onGrowth(() => this.grown());
      this.grown(wanted);
    }

    dispose() { this.disposed = true; this.player.dispose(); }

    async grown(wanted) {
      foundry.showState(this.state, this.data);
      this.clock.setSteps(this.data.done);
      this.player.showGrowing(!this.data.ended && foundry.source.live);
      if (wanted) {
        this.player.begin(wanted.step, this.data.written);
        if (wanted.agent !== null) this.select(wanted.agent);
      }
      if (this.agent !== null) this.loadTrack(this.agent);
      await this.data.loadMarks(() => this.player.timeline.draw());
    }

    select(agent) {
      const known = agent !== null && agent >= 0 && agent < this.data.about.agents ? agent : null;
      this.agent = known;
      this.grid.selected = known;
      this.grid.track = null;
      this.ownMarks = null;
      this.player.showWhose(known === null ? "" : `of agent ${known} alone`);
      this.inspector.select(known, null);
      this.player.timeline.draw();
      this.update();
      if (known !== null) this.loadTrack(known);
    }

    async loadTrack(agent) {
      const track = await this.data.track(agent);
      if (this.agent !== agent) return;
      this.grid.track = track;
      this.ownMarks = this.marksOf(track);
      this.player.timeline.draw();
      this.inspector.select(agent, track);
      this.update();
    }

    /** Return the marks of one agent, so that the timeline and the jumps are about it alone. */
    marksOf(track) {
      const names = this.data.about.outcomes, fine = ["chosen", "repaired"];
      const both = track.outcome.map((code, index) => [names[code], names[track.message_outcome[index]]]);
      return {
        undecided: both.map((two) => two.filter((one) => !fine.includes(one)).length),
        repaired: both.map((two) => two.filter((one) => one === "repaired").length),
        said: track.flags.map((flags) => flags & SAID),
      };
    }

    update() {
      const {clock, data} = this;
      const ready = this.grid.draw(clock.steps ? clock.step : 0, clock.share);
      if (!ready && clock.steps) data.load(clock.step).then(() => this.disposed || this.redraw(), () => null);
      if (!clock.playing || clock.speed <= 4) this.showDecisions();
      if (!clock.playing) {
        this.grid.canvas.setAttribute("aria-label", this.grid.describe());
        foundry.remember({step: clock.step, agent: this.agent});
      }
    }

    /** Show the chosen agent's step; with none chosen, whose decisions at this step are worth a look. */
    showDecisions() {
      const step = this.clock.steps ? this.clock.step : 0;
      this.inspector.show(step, this.agent === null ? this.grid.remarkable() : null);
    }

    redraw() {
      this.grid.draw(this.clock.step, this.clock.share);
      this.showDecisions();
      this.grid.canvas.setAttribute("aria-label", this.grid.describe());
    }

    key(key) {
      const {agents} = this.data.about;
      if (key === "[" || key === "]") this.select(this.agent === null ? 0 : (this.agent + (key === "]" ? 1 : agents - 1)) % agents);
      else if (key === "Escape") this.select(null);
      else if (key === "/") this.search.focus();
      else return false;
      return true;
    }
  }

  foundry.GridPage = GridPage;
})(window.Foundry);
