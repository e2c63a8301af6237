"use strict";
/* Describes one moment of compared runs in a sentence, and lists the moments at which decisions first differed after equal prompts. */
(function (foundry) {
  const {h, fill, grouped} = foundry.dom;
  const MOST = 11, SHORT = 60;
  const LOOKING = "Looking for the first decision in which the runs differ…";
  const SAME = "the same prompt", FINE = ["chosen", "repaired", undefined];

  /** Return the name of a moment of an agent. */
  function placeOf(step, agent) { return `${step}/${agent}`; }

  /** Return whether two runs have the same world and seed; only such runs are searched for differences. */
  function isPaired({about: a}, {about: other}) { return a.world === other.world && a.seed === other.seed; }

  /** Return the first decisions in which the runs differ from the first run, as {step, agent, kind, asked}, the earliest first. */
  async function partingsOf(runs) {
    const [first, ...others] = runs, partings = new Map();
    const replies = await Promise.all(others.filter((run) => isPaired(first, run)).map((run) =>
      foundry.source.json(`sweep/${first.sweep}/partings/${[first.id, run.id].sort().join("/")}`)));
    for (const [step, agent, kind, asked] of replies.flatMap((reply) => reply.partings)) {
      if (!partings.has(placeOf(step, agent))) partings.set(placeOf(step, agent), {step, agent, kind, asked});
    }
    return [...partings.values()].sort((a, b) => a.step - b.step || a.agent - b.agent).slice(0, MOST);
  }

  function cut(text) { return text.length > SHORT ? `${text.slice(0, SHORT)}…` : text; }

  /** Return a decision of any form in words. */
  function chosen({message, action}, kind) {
    if (kind === "message") return message === null || message === undefined ? "said nothing" : `said “${cut(message)}”`;
    return action === null || action === undefined ? "chose nothing" : `chose ${cut(typeof action === "string" ? action : JSON.stringify(action))}`;
  }

  /** Return a decision of a run in words. `kind` is the kind of question; null for any. */
  function gist(run, decision, kind) {
    const record = decision.records.find((row) => kind === null || row.kind === kind || row.kind === undefined);
    if (!record) return "made no decision";
    if (!FINE.includes(run.form.outcome(decision, kind || record.kind || "action", 0))) return "gave no readable reply";
    return (run.form.decided || chosen)(record, kind, run.about);
  }

  /** Return whether all runs sent the same messages. */
  function areAskedAlike(decisions, kind) {
    const sent = decisions.map(({calls}) => JSON.stringify(calls.filter((call) => kind === null || call.kind === kind).map((call) => call.messages)));
    return new Set(sent).size === 1 && sent[0] !== "[]";
  }

  class Partings {
    /**
     * @param names of the runs
     * @param onPick called with the step and the agent of a difference
     */
    constructor(runs, names, onPick) {
      Object.assign(this, {runs, names, onPick, all: null});
      this.sentence = h("p", {class: "sentence", role: "status"}, LOOKING);
      this.chips = h("p", {class: "chips", "aria-label": "Decisions that differ after the same prompt"});
      this.element = h("div", {class: "verdict"}, this.sentence);
    }

    /** Return the first difference, or null if there is none. */
    async load() {
      this.all = await partingsOf(this.runs);
      return this.all[0] || null;
    }

    at(step, agent) { return (this.all || []).find((parting) => parting.step === step && parting.agent === agent) || null; }

    /** Describe a moment: the prompts and the decisions of the runs. */
    show(step, agent, decisions) {
      const parting = this.at(step, agent), kind = parting && parting.kind, {runs} = this;
      const whose = runs.some((run) => run.about.agents > 1) ? `agent ${agent}, ` : "";
      const asked = parting ? `with the same prompt${parting.asked === SAME ? "" : ", except for the agent's own earlier words"}` : areAskedAlike(decisions, kind) ? "with the same prompt" : "with different prompts";
      const by = grouped(decisions.map((decision, index) => ({name: this.names[index], did: gist(runs[index], decision, kind)})), (item) => item.did);
      const clauses = [...by].map(([did, those]) => [those.map(({name}, at) => [at ? ", " : null, h("b", {}, h("bdi", {}, name))]), " ", h("bdi", {}, did)]);
      fill(this.sentence, `Step ${step}: ${whose}${asked}: `, clauses.map((clause, at) => [at ? "; " : null, clause]), by.size === 1 && !parting && runs.length > 1 ? ", all alike" : null, ".");
      this.offer(step, agent);
    }

    /** Show that no agent is chosen. */
    clear(step) {
      fill(this.sentence, this.all === null ? LOOKING : `Step ${step}: choose an agent, or a decision that differs between the runs.`);
      this.offer(step, null);
    }

    offer(step, agent) {
      if (this.all === null) return;
      const several = this.runs.some((run) => run.about.agents > 1), chip = (parting) => h("button", {type: "button", class: "chip",
        "aria-pressed": String(parting.step === step && parting.agent === agent), onclick: () => this.onPick(parting.step, parting.agent)},
      `step ${parting.step}${several ? ` · agent ${parting.agent}` : ""}${parting.kind === "action" || !parting.kind ? "" : ` · ${parting.kind}`}`);
      fill(this.chips, this.all.length ? ["Different decisions after the same prompt: ", this.all.map(chip)]
        : h("span", {class: "note"}, "After the same prompt, the runs always decide alike."));
    }
  }

  Object.assign(foundry, {Partings});
})(window.Foundry);
