"use strict";
/* Compares runs step by step: the first decision that differs after equal prompts, the replies, and the runs around it. */
(function (foundry) {
  const {h, fill, badge} = foundry.dom;
  const LISTED = 12, NAMED = 3;

  /** Return the names of the runs: their models, or longer names if models are not unique. */
  function namesOf(runs) {
    const models = runs.map((run) => run.about.model);
    return new Set(models).size === models.length ? models : runs.map((run) => run.name);
  }

  class ComparePage {
    /** @param left the requested runs that are not shown: {run, why} */
    constructor(runs, wanted, left = []) {
      this.runs = runs;
      this.agent = null;
      this.panels = runs.map((run) => this.panel(run));
      const names = this.names = namesOf(runs), looks = foundry.looks.ofRuns(runs);
      this.notes = new foundry.Notes(runs[0].sweep, runs.map(({id}, index) => ({id, name: names[index]})), {
        where: () => ({step: this.clock.step || null, agent: this.agent}), onPick: ({step, agent}) => this.goTo(step, agent)});
      this.notes.load();
      this.player = new foundry.Player({marks: () => this.marks(), ...this.playing(), summary: () => "", notes: this.notes,
        keys: [...new Set(this.panels.flatMap(({view}) => view.constructor.KEYS || []))], agents: this.agents > 1 && {most: () => this.agents, chosen: () => this.agent, select: (agent) => this.select(agent)}});
      this.clock = this.player.clock;
      this.clock.isReady = (step) => runs.every((run) => step > run.done || run.chunkAt(step) !== null);
      this.clock.onChange(() => this.update());
      this.partings = new foundry.Partings(runs, names, (step, agent) => this.goTo(step, agent));
      this.now = h("p", {class: "now"});
      this.decisions = h("div", {class: "columns"});
      this.texts = new foundry.Texts(names);
      this.overTime = new foundry.OverTime(runs, this.clock, {names, looks});
      this.overlay = this.together({names, looks, onPick: (agent) => this.select(agent)});
      const [{form, about}] = runs;
      this.element = h("div", {class: "run compare"}, this.heading(left),
        h("section", {class: "parting", "aria-label": "Where the runs differ"}, this.partings.element, this.texts.replies, this.partings.chips),
        this.player.element, this.now, h("div", {class: "around"}, h("div", {}, this.seen(looks), form.legend ? form.legend(about, this.overlay !== null) : null), this.overTime.element), this.texts.element,
        h("details", {class: "in-full"}, h("summary", {}, "each decision in full"), this.decisions), this.notes.element);
      runs.forEach((run) => run.onGrowth(() => this.grown()));
      this.grown(wanted);
    }

    dispose() {
      this.disposed = true;
      this.player.dispose();
      this.panels.forEach((panel) => panel.view.dispose && panel.view.dispose());
    }

    /** Return the options of the player: the jumps and marks that all runs have, and the fires of the first run. */
    playing() {
      const each = this.runs.map((run) => run.form.player(run.about)), [first] = each;
      const shared = (key) => first[key].filter((item) => each.every((other) => other[key].includes(item)));
      return {kinds: shared("kinds"), signs: shared("signs"), fires: first.fires};
    }

    /** Return a picture with all runs, or null if this is impossible. */
    together(options) {
      const [{form}] = this.runs;
      return form.overlay && this.runs.every((run) => run.form === form) ? form.overlay(this.runs, options) : null;
    }

    /**
     * Return the pictures of the runs: the arrangement of their form, or one panel per run, or, on request, one picture
     * of all runs.
     */
    seen(looks) {
      const {runs, panels, overlay} = this, [{form}] = runs;
      if (form.arranged && runs.every((run) => run.form === form)) return [form.arranged(panels, looks), overlay && overlay.box];
      const apart = h("div", {class: "panels"}, panels.map((panel) => panel.element));
      if (!overlay) return apart;
      overlay.box.hidden = true;
      const turn = (event) => {
        overlay.box.hidden = !event.target.checked;
        apart.hidden = event.target.checked;
        this.update();
      };
      this.linkMaps();
      return [h("label", {class: "choices"}, h("input", {type: "checkbox", onchange: turn}), "all on one map"), apart, overlay.box];
    }

    /** If the user zooms or moves one map, show the same part on all maps. */
    linkMaps() {
      const maps = this.panels.map(({view}) => view);
      maps.forEach((map) => { map.options.onCamera = (camera) => maps.forEach((other) => { if (other !== map) other.camera = camera || "1,0,0"; }); });
    }

    get agents() { return Math.max(...this.runs.map((run) => run.about.agents)); }

    panel(run) {
      const view = run.form.panel(run, {onPick: (agent) => this.select(agent)});
      const state = h("span", {class: "state"}, badge(run.progress.status));
      const element = h("section", {class: "panel", "aria-label": run.name}, h("h2", {}, h("a", {href: `#/run/${run.sweep}/${run.id}`}, run.about.model), " ", state), view.element);
      return {run, view, state, element};
    }

    /** Return the heading: the compared runs, equal settings, differing settings in red, and links to the neighbouring seeds. */
    heading(left) {
      const {runs, names} = this, all = runs.length + left.length;
      const title = left.length ? `${runs.length} of ${all} runs side by side` : runs.length > NAMED ? `${runs.length} runs side by side` : names.join(" · ");
      return h("header", {}, h("div", {class: "heading"}, h("h1", {}, title), this.pairing(), this.otherSeeds()),
        left.length ? h("div", {class: "warning left-out"}, "Not shown: ", h("ul", {}, left.map(({run, why}) => h("li", {}, h("a", {href: `#/run/${runs[0].sweep}/${run}`}, run), `: ${why}`)))) : null);
    }

    pairing() {
      const {runs} = this, values = (read) => [...new Set(runs.map((run) => String(read(run.about))))];
      const names = Object.keys(runs[0].about.factors).filter((name) => !["model", "world", "seed", "prompt"].includes(name));
      const facts = [...["world", "seed", "prompt"].map((name) => [name, values((about) => about[name])]), ...names.map((name) => [name, values((about) => about.factors[name])])];
      const paired = facts.filter(([, all]) => all.length === 1), unpaired = facts.filter(([, all]) => all.length > 1);
      return [h("p", {class: "paired"}, paired.map(([name, [value]]) => `same ${name}: ${value}`).join(" · ")),
        unpaired.length ? h("p", {class: "warning"}, `Different ${unpaired.map(([name, all]) => `${name}: ${all.join(", ")}`).join("; ")}`) : null];
    }

    /** Return links to the same models, step and agent with the previous and the next seed. */
    otherSeeds() {
      const beside = (by) => this.runs.map(({id, about}) => about.beside.seeds[about.beside.seeds.indexOf(id) + by]);
      return [[-1, "◂ previous seed"], [1, "next seed ▸"]].map(([by, text]) => [beside(by), text]).filter(([ids]) => ids.every(Boolean))
        .map(([ids, text]) => h("a", {class: "seed", href: `#/compare/${this.runs[0].sweep}/${ids.join("/")}`, onclick: (event) => {
          event.currentTarget.setAttribute("href", `#/compare/${this.runs[0].sweep}/${ids.join("/")}?step=${this.clock.step}${this.agent === null ? "" : `&agent=${this.agent}`}`);
        }}, text));
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
        this.opening = wanted.step === null && wanted.agent === null && !this.clock.following;
      }
      this.overTime.load().catch((error) => { this.overTime.element.hidden = false; fill(this.overTime.legend, h("span", {class: "warning"}, error.message)); });
      this.runs.forEach((run) => run.loadMarks(() => this.player.timeline.draw()));
      if (!this.first && !this.looking) await this.look();
    }

    /** Find the first difference between the runs, and go to it unless the user has gone elsewhere. */
    async look() {
      const stopped = () => this.disposed, {position} = this.clock;
      this.looking = true;
      const first = await this.partings.load().catch((error) => { fill(this.partings.chips, h("span", {class: "warning"}, error.message)); return null; });
      const place = first || await foundry.difference.firstDifference(this.runs, stopped);
      this.looking = false;
      if (stopped()) return;
      this.first = first;
      if (this.opening && place && this.clock.position === position && this.agent === null) this.goTo(place.step, place.agent);
      this.opening = false;
      this.shown = null;
      await this.update();
    }

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
      await this.showDecisions(clock.step, wanted);
      await this.showDifferences(clock.step, wanted);
    }

    draw(run, view, clock) {
      const step = Math.min(clock.step, run.done), share = clock.step > run.done ? 1 : clock.share;
      if (!view.draw(step, share) && step) run.load(step).then(() => this.disposed || view.draw(step, share), () => null);
      if (!clock.playing) view.label(run.name);
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
      fill(this.now, `Step ${step}: `, agents.length === 0 ? "all runs decide alike." : this.agents > 1
        ? [agents.length > 1 ? `${agents.length} agents decide differently: ` : "one agent decides differently: ", agents.slice(0, LISTED).map(pick), agents.length > LISTED ? " …" : null] : "the decisions differ.");
    }

    async showDecisions(step, wanted) {
      const agent = this.agents > 1 ? this.agent : 0;
      if (agent === null) {
        this.partings.clear(step);
        this.texts.clear();
        fill(this.decisions, h("p", {class: "note"}, "Choose an agent to see the decision of each run."));
        return;
      }
      const decisions = await Promise.all(this.runs.map((run) => run.decision(step, agent)));
      if (this.shown !== wanted) return;
      const parting = this.partings.at(step, agent);
      this.partings.show(step, agent, decisions);
      this.texts.show(decisions, parting && parting.kind);
      fill(this.decisions, decisions.map((decision, index) => this.column(this.runs[index], decision)));
    }

    column(run, decision) {
      const details = decision.record ? run.form.decision(decision) : h("p", {class: "note"}, "This run has no record of the step.");
      return h("section", {class: "column"}, h("h3", {}, run.about.model), details);
    }
  }

  foundry.ComparePage = ComparePage;
})(window.Foundry);
