"use strict";
/* Two to four runs on one clock, where they part, and the decision of each. */
(function (foundry) {
  const {h, fill, badge, quote} = foundry.dom;
  const LISTED = 12;

  class ComparePage {
    constructor(runs, wanted) {
      this.runs = runs;
      this.agent = null;
      this.panels = runs.map((run) => this.panel(run));
      this.player = new foundry.Player({marks: () => this.marks(), ...this.playing(), onKey: (key) => this.key(key), summary: () => ""});
      this.clock = this.player.clock;
      this.clock.isReady = (step) => runs.every((run) => step > run.done || run.chunkAt(step) !== null);
      this.clock.onChange(() => this.update());
      this.verdict = h("section", {class: "verdict", "aria-label": "Where the runs part"}, h("p", {class: "note"}, "Looking for the first difference…"));
      this.now = h("p", {class: "now"});
      this.decisions = h("div", {class: "columns"});
      this.element = h("div", {class: "run compare"}, h("h1", {}, `${runs.length} runs side by side`), this.warning(), this.verdict, this.player.element,
        h("div", {class: `panels of-${runs.length}`}, this.panels.map((one) => one.element)), this.now, this.decisions);
      runs.forEach((run) => run.onGrowth(() => this.grown()));
      this.grown(wanted);
    }

    dispose() {
      this.disposed = true;
      this.player.dispose();
      this.panels.forEach((one) => one.view.dispose && one.view.dispose());
    }

    /** What the player of all of them has: the jumps and signs that each of them knows, the fires of the first. */
    playing() {
      const each = this.runs.map((run) => run.form.player(run.about)), [first] = each;
      const shared = (key) => first[key].filter((one) => each.every((other) => other[key].includes(one)));
      return {kinds: shared("kinds"), signs: shared("signs"), fires: first.fires};
    }

    get agents() { return Math.max(...this.runs.map((run) => run.about.agents)); }

    panel(run) {
      const view = run.form.panel(run, {onPick: (agent) => this.select(agent)});
      const state = h("span", {class: "state"}, badge(run.progress.status));
      const element = h("section", {class: "panel", "aria-label": run.name},
        h("h2", {}, h("a", {href: `#/run/${run.sweep}/${run.id}`}, run.about.model), h("small", {}, ` ${run.about.prompt} · seed ${run.about.seed} `), state), view.element);
      return {run, view, state, element};
    }

    warning() {
      const seeds = new Set(this.runs.map((run) => run.about.seed)), worlds = new Set(this.runs.map((run) => run.about.world));
      if (seeds.size === 1 && worlds.size === 1) return null;
      return h("p", {class: "warning"}, "These runs differ in more than the model: they have not the same seed and world.");
    }

    /** Sums of the marks of all runs. */
    marks() {
      const sum = {};
      for (const run of this.runs) {
        for (const [name, values] of Object.entries(run.marks)) {
          sum[name] = sum[name] || [];
          values.forEach((value, index) => { sum[name][index] = (sum[name][index] || 0) + value; });
        }
      }
      return sum;
    }

    async grown(wanted) {
      this.panels.forEach(({run, state}) => foundry.showState(state, run));
      this.clock.setSteps(Math.max(...this.runs.map((run) => run.done)));
      this.player.showGrowing(foundry.source.live && this.runs.some((run) => !run.ended));
      if (wanted) {
        this.player.begin(wanted.step, this.runs.some((run) => run.written));
        if (wanted.agent !== null) this.select(wanted.agent);
      }
      this.runs.forEach((run) => run.loadMarks(() => this.player.timeline.draw()));
      if (!this.found) await this.look();
    }

    async look() {
      const stopped = () => this.disposed;
      const done = await foundry.difference.firstDifference(this.runs, stopped);
      const said = await foundry.difference.firstText(this.runs, stopped);
      if (stopped()) return;
      this.found = done && said;
      const line = (what, hit) => h("p", {}, h("b", {}, what), hit ? [" step ", h("button", {type: "button", class: "go", onclick: () => this.go(hit)}, String(hit.step)),
        ` (${this.agents > 1 ? `${hit.agents.length > 1 ? "agents" : "agent"} ${this.list(hit.agents)}` : "the decision"})`] : " none in the steps that all of them have");
      const {words} = this.runs[0].form;
      fill(this.verdict, line(`First ${words.did} that differs:`, done), line(`First ${words.said} that differs:`, said));
    }

    list(agents) { return agents.length > LISTED ? `${agents.slice(0, LISTED).join(", ")} and ${agents.length - LISTED} more` : agents.join(", "); }

    go(hit) {
      this.clock.pause();
      this.clock.seek(hit.step);
      this.select(hit.agents[0]);
    }

    select(agent) {
      this.agent = agent !== null && agent >= 0 && agent < this.agents ? agent : null;
      this.panels.forEach(({view}) => view.select(this.agent));
      this.shown = null;
      this.update();
    }

    async update() {
      const {clock} = this;
      if (!clock.steps) return;
      for (const {run, view} of this.panels) this.draw(run, view, clock);
      if (clock.playing) return;
      foundry.remember({step: clock.step, agent: this.agent});
      const wanted = `${clock.step}/${this.agent}/${this.runs.map((run) => run.done)}`;
      if (this.shown === wanted) return;
      this.shown = wanted;
      await this.showDifferences(clock.step, wanted);
      await this.showDecisions(clock.step, wanted);
    }

    draw(run, view, clock) {
      const step = Math.min(clock.step, run.done), share = clock.step > run.done ? 1 : clock.share;
      if (!view.draw(step, share) && step) run.load(step).then(() => this.disposed || view.draw(step, share), () => null);
      view.label(run.name);
    }

    async showDifferences(step, wanted) {
      const agents = await foundry.difference.differingAgents(this.runs, step);
      if (this.shown !== wanted) return;
      const pick = (agent) => h("button", {type: "button", class: "go", "aria-label": `Agent ${agent}`, onclick: () => this.select(agent)}, String(agent));
      fill(this.now, h("b", {}, `At step ${step}: `), agents.length === 0 ? "all do the same." : this.agents > 1
        ? [agents.length > 1 ? `${agents.length} agents differ: ` : "one agent differs: ", agents.slice(0, LISTED).map(pick), agents.length > LISTED ? " …" : null] : "the decisions differ.");
    }

    async showDecisions(step, wanted) {
      const agent = this.agents > 1 ? this.agent : 0;
      if (agent === null) { fill(this.decisions, h("p", {class: "note"}, "Choose an agent to see the decision of each run.")); return; }
      const found = await Promise.all(this.runs.map((run) => run.decision(step, agent)));
      if (this.shown !== wanted) return;
      fill(this.decisions, found.map((decision, index) => this.column(this.runs[index], step, agent, decision)));
    }

    column(run, step, agent, decision) {
      const {record} = decision;
      const details = record ? run.form.decision(decision) : h("p", {class: "note"}, "No record of this step.");
      return h("section", {class: "column"}, h("h3", {}, `${run.about.model} · step ${step}${this.agents > 1 ? ` · agent ${agent}` : ""}`), details,
        decision.calls.length ? h("h4", {}, "Raw replies") : null, decision.calls.map((call) => [h("p", {class: "role"}, call.kind), quote(call.text, "reply")]));
    }

    key(key) {
      const most = this.agents;
      if (key === "[" || key === "]") this.select(this.agent === null ? 0 : (this.agent + (key === "]" ? 1 : most - 1)) % most);
      else if (key === "Escape") this.select(null);
      else return false;
      return true;
    }
  }

  foundry.ComparePage = ComparePage;
})(window.Foundry);
