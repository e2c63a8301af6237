"use strict";
/* The page for runs of any form: agents over time, the decisions of a step, pictures, prompts and replies. */
(function (foundry) {
  const {h, badge, quote, number} = foundry.dom, {facts, inbox, thought} = foundry.parts;
  const FINE = ["chosen", "repaired", undefined];
  const LONG = 60;

  /** Group the lines of a chunk by their step, and by their step and agent. */
  function chunk(block) {
    const ofStep = new Map(), ofAgent = new Map();
    const add = (map, key, row) => { if (map.has(key)) map.get(key).push(row); else map.set(key, [row]); };
    for (const row of block.rows) {
      add(ofStep, row.step, row);
      add(ofAgent, `${row.step}/${row.agent}`, row);
    }
    return {first: block.first, last: block.last, ofStep, ofAgent};
  }

  function same(chunk, about, step, agent) {
    return JSON.stringify((chunk.ofAgent.get(`${step}/${agent}`) || []).map((row) => [row.kind, row.action, row.outcome]));
  }

  function action(value) {
    return value === null || value === undefined ? "no action" : typeof value === "number" ? number(value, 6) : typeof value === "string" ? value : JSON.stringify(value);
  }

  /** One line of steps.jsonl: the decision, its outcome, and the keys that only this world has. */
  function recordView(record, several) {
    const own = foundry.anyTables.keysOf([record], [], [...foundry.anyTables.COMMON, "reasoning"]).map((key) => [key, record[key]])
      .filter(([, value]) => value !== null && value !== "" && !(Array.isArray(value) && !value.length));
    const isLong = ([, value]) => typeof value === "string" && (value.length > LONG || value.includes("\n"));
    const plain = ([key, value]) => [key, typeof value === "number" ? number(value, 6) : typeof value === "string" ? h("bdi", {}, value) : JSON.stringify(value)];
    return [
      h("h4", {class: several ? "kind" : null}, several ? h("bdi", {}, record.kind ?? "decision") : "Did"),
      facts([["action", h("span", {}, record.outcome ? badge(record.outcome) : null, " ", h("bdi", {}, action(record.action)))],
        ["utility", typeof record.utility === "number" ? number(record.utility, 6) : null], ...own.filter((key) => !isLong(key)).map(plain)]),
      typeof record.message === "string" ? [h("h4", {}, "Said"), quote(record.message)] : null,
      own.filter(isLong).map(([key, value]) => [h("h4", {}, key), quote(value)]),
    ];
  }

  function decision({records, calls, ...rest}) {
    const reasons = records.map((record) => ["Thought", record.reasoning]);
    return [inbox(rest), thought(reasons, calls), records.map((record) => recordView(record, records.length > 1))];
  }

  /** Return what an agent did at a step: its actions in words, its message, and the outcomes of its decisions. */
  function summed(rows) {
    const acts = rows.filter((row) => row.action !== null && row.action !== undefined), several = new Set(rows.map((row) => row.kind)).size > 1;
    const words = acts.map((row) => (several ? `${row.kind}: ${action(row.action)}` : action(row.action)));
    return {action: words.join(", ") || "no action", said: rows.map((row) => row.message).find((text) => typeof text === "string") ?? null,
      outcomes: rows.map((row) => row.outcome).filter((outcome) => outcome !== undefined)};
  }

  function gist({records}) {
    const {action: did, said} = summed(records);
    return {thoughts: records.map((record) => record.reasoning), did, said};
  }

  /**
   * Return the outcome of a call by its kind and its number among the calls of this kind. A line without a kind stands for
   * all calls of the step. If the numbers of lines and calls differ, they cannot be matched; a failure then counts for every
   * call.
   */
  function outcome({records, calls}, kind, before) {
    const named = records.filter((record) => record.kind === kind);
    if (named.length === calls.filter((call) => call.kind === kind).length) return named[before].outcome;
    const lines = named.length ? named : records.filter((record) => record.kind === undefined);
    return (lines.find((record) => !FINE.includes(record.outcome)) || lines[0] || {}).outcome;
  }

  /**
   * The page of a run. A form may extend it with three methods. `stage()` returns the elements beside the inspector. The
   * page calls `drawStep(step, share)` when the clock moves; it calls `chosen()` when the user chooses another agent.
   */
  class AnyPage {
    constructor(data, wanted) {
      this.data = data;
      this.agent = null;
      const select = (agent) => this.select(agent);
      this.lanes = new foundry.Lanes(data, {onPick: (agent, step) => { this.select(agent); if (step !== null) this.go(step); }});
      this.curves = new foundry.Curves(data, this.lanes);
      this.picture = new foundry.Picture(data);
      this.table = new foundry.anyTables.StepTable(data, select);
      this.streams = new foundry.anyTables.StreamTables(data);
      this.inspector = new foundry.Inspector(data, select, (step) => this.go(step), (step) => this.decided(step));
      this.search = new foundry.Search(data, "Search in messages", (step, agent) => { select(agent); this.go(step); });
      this.notes = foundry.notesOfRun(this);
      this.player = new foundry.Player({marks: () => this.ownMarks || data.marks, ...data.form.player(data.about), ...data.happening(() => this.agent), summary: () => this.lanes.describe(),
        agents: {most: () => data.about.agents, chosen: () => this.agent, select}, search: this.search, notes: this.notes});
      this.clock = this.player.clock;
      this.clock.onChange(() => this.update());
      this.state = h("span", {class: "state"});
      this.warning = h("p", {class: "warning", hidden: true});
      this.main = h("div", {class: "main"}, this.stage());
      this.element = h("div", {class: "run any fits"}, foundry.runHeading(data, this.state), this.player.element, this.warning,
        h("div", {class: "stage"}, this.main, h("div", {class: "side"}, this.notes.element, this.search.element, this.inspector.element, this.table.element, this.streams.element)));
      data.onGrowth(() => this.grown());
      data.onAnalysis(() => { this.player.redraw(); this.curves.redraw(); });
      this.grown(wanted);
    }

    stage() { return [this.lanes.element, this.curves.element, this.picture.element]; }

    drawStep(step, share) {}

    chosen() {}

    dispose() { this.disposed = true; this.player.dispose(); this.picture.dispose(); }

    go(step) { this.clock.pause(); this.clock.seek(step); }

    async grown(wanted) {
      const {data} = this;
      foundry.showState(this.state, data);
      this.inspector.offer();
      this.clock.setSteps(data.done);
      this.player.showGrowing(!data.ended && foundry.source.live);
      if (wanted) {
        this.player.begin(wanted.step, data.written);
        if (wanted.agent !== null) this.select(wanted.agent);
      }
      if (this.agent !== null) this.loadTrack(this.agent);
      await this.trying(async () => {
        await this.lanes.load();
        await this.curves.load();
        if (data.done) await this.picture.look();
        await data.loadMarks(() => this.player.timeline.draw());
      });
    }

    /** Run a function. If it fails, show the reason on the page. */
    async trying(something) {
      try {
        await something();
        this.warning.hidden = true;
      } catch (error) {
        this.warning.textContent = error.message;
        this.warning.hidden = false;
      }
    }

    select(agent) {
      const known = agent !== null && agent >= 0 && agent < this.data.about.agents ? agent : null;
      this.agent = known;
      this.ownMarks = null;
      this.lanes.select(known);
      this.player.showWhose(known === null ? "" : `of agent ${known} alone`);
      this.inspector.select(known, null);
      this.player.redraw();
      this.shown = null;
      this.chosen();
      this.update();
      if (known !== null) this.loadTrack(known);
    }

    async loadTrack(agent) {
      const track = await this.data.track(agent);
      if (this.agent !== agent) return;
      this.ownMarks = track.marks;
      this.player.timeline.draw();
      this.inspector.select(agent, track);
      this.update();
    }

    update() {
      const {clock, data} = this;
      if (!clock.steps) return;
      this.lanes.seek(clock.position);
      this.curves.redraw();
      this.drawStep(clock.step, clock.share);
      if (!clock.playing) foundry.remember({step: clock.step, agent: this.agent});
      if (!clock.playing || clock.speed <= 4) this.showStep(clock.step);
      data.prefetch(clock.step);
    }

    /** Show the lines of a step when they are loaded. */
    async showStep(step) {
      const wanted = `${step}/${this.agent}/${this.data.progress.beginning}`;
      this.inspector.show(step);
      if (this.shown === wanted) return;
      this.shown = wanted;
      this.picture.show(step);
      await this.trying(async () => {
        const rows = (await this.data.load(step)).ofStep.get(step) || [];
        if (this.shown !== wanted || this.disposed) return;
        this.table.show(step, rows, this.agent);
        await this.streams.show(step);
      });
    }

    /** Return the actions and messages at a step, by agent. */
    async decided(step) {
      const {ofStep} = await this.data.load(step);
      return new Map([...foundry.dom.grouped(ofStep.get(step) || [], (row) => row.agent)].map(([agent, rows]) => [agent, summed(rows)]));
    }
  }

  /** The panel of a run on the page that compares runs: its rows and its picture. */
  class AnyPanel {
    constructor(data, {onPick}) {
      this.data = data;
      this.lanes = new foundry.Lanes(data, {onPick: (agent) => onPick(agent)});
      this.picture = new foundry.Picture(data);
      this.element = h("div", {class: "any"}, this.lanes.element, this.picture.element);
      data.onGrowth(() => this.load());
      this.load();
    }

    load() {
      this.lanes.load().catch(() => null); // the list of decisions below shows unreadable replies
      if (this.data.done) this.picture.look().catch(() => null);
    }

    draw(step, share) {
      this.lanes.seek(step + share);
      if (this.step !== step) this.picture.show(step);
      this.step = step;
      return step > 0 && this.data.chunkAt(step) !== null;
    }

    select(agent) { this.lanes.select(agent); }

    label(name) { this.lanes.canvas.setAttribute("aria-label", `${name}. ${this.lanes.describe()}`); }

    dispose() { this.picture.dispose(); }
  }

  foundry.form("any", {
    needs: ["any/colours.js", "any/run_lanes.js", "any/lanes.js", "any/curves.js", "any/picture.js", "any/tables.js"],
    page: (data, wanted) => new AnyPage(data, wanted),
    panel: (data, options) => new AnyPanel(data, options),
    chunk, same, decision, gist, outcome,
    player: () => ({kinds: ["message", "failure"], signs: [], fires: []}),
    Page: AnyPage,
  });
})(window.Foundry);
