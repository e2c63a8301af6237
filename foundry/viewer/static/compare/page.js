"use strict";
/* Runs on one clock, where they part, and the decision of each. */
(function (foundry) {
  const {h, fill, badge} = foundry.dom;
  const LISTED = 12;

  /** Return what the runs are called: their models, or more where that does not tell them apart. */
  function namesOf(runs) {
    const models = runs.map((run) => run.about.model);
    return new Set(models).size === models.length ? models : runs.map((run) => run.name);
  }

  class ComparePage {
    /** @param left the runs that were asked for and are not shown: {run, why} */
    constructor(runs, wanted, left = []) {
      this.runs = runs;
      this.agent = null;
      this.panels = runs.map((run) => this.panel(run));
      const names = namesOf(runs), looks = foundry.looks.ofRuns(runs);
      this.notes = new foundry.Notes(runs[0].sweep, runs.map(({id}, index) => ({id, name: names[index]})), {
        where: () => ({step: this.clock.step || null, agent: this.agent}), onPick: ({step, agent}) => this.goTo(step, agent)});
      this.notes.load();
      this.player = new foundry.Player({marks: () => this.marks(), ...this.playing(), summary: () => "", notes: this.notes,
        keys: [...new Set(this.panels.flatMap(({view}) => view.constructor.KEYS || []))], agents: this.agents > 1 && {most: () => this.agents, chosen: () => this.agent, select: (agent) => this.select(agent)}});
      this.clock = this.player.clock;
      this.clock.isReady = (step) => runs.every((run) => step > run.done || run.chunkAt(step) !== null);
      this.clock.onChange(() => this.update());
      this.verdict = h("section", {class: "verdict", "aria-label": "Where the runs part"}, h("p", {class: "note"}, "Looking for the first difference…"));
      this.now = h("p", {class: "now"});
      this.decisions = h("div", {class: "columns"});
      this.texts = new foundry.Texts(names);
      this.overTime = new foundry.OverTime(runs, this.clock, {names, looks});
      this.moment = new foundry.Moment(this.clock, () => ({panels: this.panels, agent: this.agent, decisions: () => this.decided()}));
      this.overlay = this.together({names, looks, onPick: (agent) => this.select(agent)});
      const [{form, about}] = runs;
      this.element = h("div", {class: "run compare"}, this.heading(left), this.warning(), this.verdict, this.player.element, this.moment.element, this.seen(looks),
        form.legend ? form.legend(about, this.overlay !== null) : null, this.overlay && this.overlay.box, this.now, this.decisions, this.texts.element, this.notes.element);
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

    /** Return what shows all runs in one picture, or null where they cannot be. */
    together(options) {
      const [{form}] = this.runs;
      return form.overlay && this.runs.every((run) => run.form === form) ? form.overlay(this.runs, options) : null;
    }

    /** Return what is seen of the runs and the numbers over time: panels in a grid, or as the form of all of them puts them. */
    seen(looks) {
      const {runs, panels} = this, [{form}] = runs;
      if (form.arranged && runs.every((run) => run.form === form)) return [form.arranged(panels, looks), this.overTime.element];
      return [this.overTime.element, h("div", {class: `panels of-${runs.length > 4 ? "many" : runs.length}`}, panels.map((one) => one.element))];
    }

    get agents() { return Math.max(...this.runs.map((run) => run.about.agents)); }

    panel(run) {
      const view = run.form.panel(run, {onPick: (agent) => this.select(agent)});
      const state = h("span", {class: "state"}, badge(run.progress.status));
      const element = h("section", {class: "panel", "aria-label": run.name},
        h("h2", {}, h("a", {href: `#/run/${run.sweep}/${run.id}`}, run.about.model), h("small", {}, ` ${run.about.prompt} · seed ${run.about.seed} `), state), view.element);
      return {run, view, state, element};
    }

    heading(left) {
      const {runs} = this, shown = `${runs.length} runs side by side`;
      if (!left.length) return h("h1", {}, shown);
      return [h("h1", {}, `${runs.length} of ${runs.length + left.length} runs side by side`),
        h("div", {class: "warning left-out"}, "Not shown: ", h("ul", {}, left.map(({run, why}) => h("li", {}, h("a", {href: `#/run/${runs[0].sweep}/${run}`}, run), `: ${why}`))))];
    }

    warning() {
      const values = (key) => [...new Set(this.runs.map((run) => run.about[key]))];
      const several = [["world", "worlds"], ["seed", "seeds"]].filter(([key]) => values(key).length > 1).map(([key, many]) => `${many} ${values(key).join(", ")}`);
      return several.length ? h("p", {class: "warning"}, `These runs differ in more than the model: ${several.join("; ")}.`) : null;
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
      this.overTime.load().catch((error) => fill(this.overTime.legend, h("span", {class: "warning"}, error.message)));
      this.runs.forEach((run) => run.loadMarks(() => this.player.timeline.draw()));
      if (!this.found) await this.look();
    }

    async look() {
      const stopped = () => this.disposed;
      const done = await foundry.difference.firstDifference(this.runs, stopped);
      const said = await foundry.difference.firstText(this.runs, stopped);
      if (stopped()) return;
      this.found = done && said;
      const line = (what, hit) => h("p", {}, h("b", {}, what), hit ? [" step ", h("button", {type: "button", class: "go", onclick: () => this.goTo(hit.step, hit.agents[0])}, String(hit.step)),
        ` (${this.agents > 1 ? `${hit.agents.length > 1 ? "agents" : "agent"} ${this.list(hit.agents)}` : "the decision"})`] : " none in the steps that two of them have");
      const {words} = this.runs[0].form;
      fill(this.verdict, line(`First ${words.did} that differs:`, done), line(`First ${words.said} that differs:`, said));
    }

    list(agents) { return agents.length > LISTED ? `${agents.slice(0, LISTED).join(", ")} and ${agents.length - LISTED} more` : agents.join(", "); }

    goTo(step, agent) {
      this.clock.pause();
      this.clock.seek(step);
      this.select(agent);
    }

    select(agent) {
      this.agent = agent !== null && agent >= 0 && agent < this.agents ? agent : null;
      this.panels.forEach(({view}) => view.select(this.agent));
      if (this.overlay) this.overlay.select(this.agent);
      this.shown = null;
      this.update();
    }

    async update() {
      const {clock} = this;
      if (!clock.steps) return;
      for (const {run, view} of this.panels) this.draw(run, view, clock);
      if (this.overlay) this.drawTogether(clock);
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
      if (!clock.playing) view.label(run.name);
    }

    /** Return the decision of each run at this moment; null where several agents are and none is chosen. */
    async decided() {
      const agent = this.agents > 1 ? this.agent : 0, {step} = this.clock;
      return agent === null ? null : Promise.all(this.runs.map((run) => run.decision(step, agent)));
    }

    drawTogether({step, share, playing}) {
      const {overlay} = this;
      overlay.draw(step, share);
      if (!playing) overlay.label();
      const missing = this.runs.filter((run) => run.done && run.chunkAt(Math.min(step, run.done)) === null);
      if (missing.length) Promise.all(missing.map((run) => run.load(Math.min(step, run.done)))).then(() => this.disposed || overlay.draw(step, share), () => null);
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
      if (agent === null) {
        fill(this.decisions, h("p", {class: "note"}, "Choose an agent to see the decision of each run."));
        this.texts.clear();
        return;
      }
      const found = await this.decided();
      if (this.shown !== wanted) return;
      fill(this.decisions, found.map((decision, index) => this.column(this.runs[index], step, agent, decision)));
      this.texts.show(found);
    }

    column(run, step, agent, decision) {
      const {record} = decision;
      const details = record ? run.form.decision(decision) : h("p", {class: "note"}, "No record of this step.");
      return h("section", {class: "column"}, h("h3", {}, `${run.about.model} · step ${step}${this.agents > 1 ? ` · agent ${agent}` : ""}`), details);
    }
  }

  foundry.ComparePage = ComparePage;
})(window.Foundry);
