"use strict";
/* The page for 2D runs: grid, timeline, agent, search. */
(function (foundry) {
  const {h, badge, quote} = foundry.dom, {facts, inbox, thought} = foundry.parts;
  const SAID = 1, AWAY = 8;
  const DEEDS = ["gather", "share", "attack", "reproduce"];

  function chunk(block, about) {
    const typed = {first: block.first, last: block.last, agents: about.agents, links: block.links, deliveries: block.deliveries};
    for (const key of ["x", "y", "place"]) typed[key] = Int16Array.from(block[key]);
    for (const key of ["action", "outcome", "message_outcome", "flags"]) typed[key] = Uint8Array.from(block[key]);
    for (const key of ["burning", "food"]) if (block[key]) typed[key] = block[key];
    return typed;
  }

  function same(chunk, about, step, agent) {
    const at = (step - chunk.first) * about.agents + agent;
    return [chunk.x[at], chunk.y[at], chunk.action[at], chunk.outcome[at], chunk.message_outcome[at], chunk.flags[at] & 8].join();
  }

  function motion(record) {
    if (record.action !== "move") return deed(record);
    const stopped = {wall: "a wall", agents: "a full cell", exit: "others at the exit"}[record.blocked] || "the edge";
    return `move ${record.direction}: ${record.moved ? `to (${record.x_next}, ${record.y_next})` : `stopped by ${stopped}`}`;
  }

  /** Actions other than moves, in worlds that have such actions. */
  function deed(record) {
    const whom = record.target === null || record.target === undefined ? "" : ` Agent ${record.target}`;
    const born = record.born ? `: Agent ${record.born[0]}` : "";
    return `${record.action}${whom}${record.amount ? `: ${record.amount}` : ""}${born}`;
  }

  /** The state and the possessions of an agent, in worlds in which agents come and go. */
  function fate(record) {
    const facts = [];
    if (record.energy !== undefined) facts.push(["energy", `${record.energy}, then ${record.energy_next}`]);
    if (record.exits) facts.push(["exits known", record.exits.join(", ") || "none"]);
    if (record.left) facts.push(["left by", record.left]);
    if (record.lost) facts.push(["died of", record.lost]);
    return facts;
  }

  function decisionView(decision) {
    const {record, earlier, calls} = decision;
    return [
      decision.received.length + decision.before.length ? inbox(decision) : h("p", {class: "note"}, `The agent received no messages since step ${decision.since}.`), thought([["Why it said so", record.message_reasoning], ["Why it acted so", record.reasoning]], calls),
      h("h4", {}, "Did"), facts([
        ["cell", `(${record.x}, ${record.y})${record.place ? ` in ${record.place}` : ""}`],
        ["action", h("span", {}, badge(record.outcome), ` ${motion(record)}`)],
        ["message", h("span", {}, badge(record.message_outcome), record.message === null ? " silent" : ` to ${record.neighbours.length || "nobody"}${{0: "", 1: " agent"}[record.neighbours.length] ?? " agents"}`)],
        ["can talk to", record.neighbours.join(", ") || "nobody"], ["fires perceived", record.fires.join(", ") || "none"],
        ...fate(record),
      ]),
      record.message === null ? null : [h("h4", {}, "Said"), quote(record.message)],
      record.memory ? [h("h4", {}, "Remembers"), quote(record.memory)] : null,
      memories(earlier),
    ];
  }

  function memories(earlier) {
    const memories = earlier.filter((row) => row.memory && row.memory.trim()).slice(-5);
    if (!memories.length) return null;
    return h("details", {class: "call"}, h("summary", {}, "Memory before this step"),
      h("ul", {class: "told"}, memories.map((row) => h("li", {}, h("b", {}, `step ${row.step}: `), h("bdi", {}, row.memory)))));
  }

  class GridPage {
    constructor(data, wanted) {
      this.data = data;
      this.agent = null;
      this.grid = new foundry.Grid(data, {onPick: (agent) => this.select(agent), onCamera: (camera) => foundry.remember({camera})});
      this.grid.camera = wanted.camera;
      this.inspector = new foundry.Inspector(data, (agent) => this.select(agent), (step) => this.go(step), (step) => this.decided(step));
      this.search = new foundry.Search(data, "Search in messages", (step, agent) => { this.select(agent); this.go(step); });
      this.notes = foundry.notesOfRun(this);
      this.player = new foundry.Player({
        marks: () => this.ownMarks || data.marks, ...data.form.player(data.about), ...data.happening(() => this.agent), summary: () => this.grid.describe(), keys: foundry.Grid.KEYS,
        agents: {most: () => data.about.agents, chosen: () => this.agent, select: (agent) => this.select(agent)}, search: this.search, notes: this.notes,
      });
      this.clock = this.player.clock;
      this.clock.isReady = (step) => data.chunkAt(step) !== null;
      this.clock.onChange(() => this.update());
      this.state = h("span", {class: "state"});
      this.element = h("div", {class: "run fits"},
        foundry.runHeading(data, this.state), this.player.element,
        h("div", {class: "stage"}, h("div", {class: "main"}, this.grid.element, h("div", {class: "foot"}, foundry.gridOverlay.legend(data.about))),
          h("div", {class: "side"}, this.notes.element, this.search.element, this.inspector.element)));
      data.onGrowth(() => this.grown());
      data.onAnalysis(() => this.player.redraw());
      this.grown(wanted);
    }

    dispose() { this.disposed = true; this.player.dispose(); }

    go(step) { this.clock.pause(); this.clock.seek(step); }

    /** Return the actions and messages at a step, by agent. */
    async decided(step) {
      const {data} = this, {about} = data, [chunk, said] = await Promise.all([data.load(step), data.said(step)]);
      const base = (step - chunk.first) * about.agents, actions = [...about.directions, ...DEEDS], acts = new Map();
      for (let agent = 0; agent < about.agents; agent += 1) {
        const at = base + agent, outcomes = [about.outcomes[chunk.outcome[at]], about.outcomes[chunk.message_outcome[at]]];
        if (!(chunk.flags[at] & AWAY)) acts.set(agent, {action: actions[chunk.action[at]], said: said.get(agent) ?? null, outcomes});
      }
      return acts;
    }

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
      this.player.redraw();
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

    /** Return the marks of one agent, so that the timeline and the jumps consider only this agent. */
    marksOf(track) {
      const names = this.data.about.outcomes, fine = ["chosen", "repaired"];
      const both = track.outcome.map((code, index) => [names[code], names[track.message_outcome[index]]]);
      return {
        undecided: both.map((two) => two.filter((name) => !fine.includes(name)).length),
        repaired: both.map((two) => two.filter((name) => name === "repaired").length),
        said: track.flags.map((flags) => flags & SAID),
      };
    }

    update() {
      const {clock, data} = this;
      const ready = this.grid.draw(clock.steps ? clock.step : 0, clock.share);
      if (!ready && clock.steps) data.load(clock.step).then(() => this.disposed || this.redraw(), () => null);
      if (!clock.playing || clock.speed <= 4) this.showDecisions();
      if (!clock.playing) {
        this.grid.label();
        foundry.remember({step: clock.step, agent: this.agent});
      }
    }

    showDecisions() { this.inspector.show(this.clock.steps ? this.clock.step : 0); }

    redraw() {
      this.grid.draw(this.clock.step, this.clock.share);
      this.showDecisions();
      this.grid.label();
    }
  }

  foundry.form("grid", {
    needs: ["grid/gestures.js", "grid/ground.js", "grid/canvas.js", "grid/overlay.js"],
    overlay: (runs, options) => foundry.gridOverlay.overlay(runs, options),
    legend: (about, together) => foundry.gridOverlay.legend(about, together),
    page: (data, wanted) => new GridPage(data, wanted),
    panel: (data, options) => new foundry.Grid(data, options),
    chunk, same,
    decision: decisionView,
    gist: ({record}) => ({thoughts: [record.message_reasoning, record.reasoning], did: motion(record), said: record.message}),
    outcome: ({record}, kind) => record && {message: record.message_outcome, action: record.outcome}[kind],
    decided: (...of) => foundry.gridOverlay.decided(...of),
    player: (about) => ({kinds: ["message", "fire", "failure"], signs: [], fires: about.fires}),
  });
})(window.Foundry);
