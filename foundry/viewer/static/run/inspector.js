"use strict";
/* Everything about one agent at one step: what it is, what it did, what it was asked and what it answered. */
(function (foundry) {
  const {h, fill, badge, quote, number} = foundry.dom;
  const LISTED = 24;
  const PATIENCE_MS = 300;

  function facts(pairs) {
    return h("dl", {class: "facts"}, pairs.filter((pair) => pair && pair[1] !== null && pair[1] !== undefined && pair[1] !== "")
      .map(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]));
  }

  function seconds(timings) {
    return Object.entries(timings || {}).map(([name, value]) => `${name} ${number(value)} s`).join(", ");
  }

  /** A prompt exactly as it was sent, its sections to fold where it has headings. */
  function prompt(text) {
    const found = foundry.words.sections(text);
    if (found.length < 2) return quote(text, "prompt");
    return found.map(([heading, body]) => (heading ? h("details", {class: "section", open: true}, h("summary", {}, h("bdi", {}, heading)), quote(body, "prompt")) : quote(body, "prompt")));
  }

  /** Return what tells a call from the others of its step: its kind, and how often this kind was put before. */
  function keyOf(kind, before) { return JSON.stringify([kind, before]); }

  /** One call: the prompt exactly as it was sent, the raw reply, how it went. */
  function callView(call, before, open) {
    const attempts = call.attempts || [];
    return h("details", {class: "call", open, "data-kind": call.kind, "data-key": keyOf(call.kind, before)},
      h("summary", {}, h("b", {}, call.kind), ` · ${call.cached ? "from the cache" : "asked"} · ended: ${call.ending}`),
      h("h4", {}, "Reply"), quote(call.text, "reply"),
      call.thinking ? [h("h4", {}, "Thinking"), quote(call.thinking)] : null,
      attempts.length ? [h("h4", {}, "Tries that failed"), h("ul", {}, attempts.map((one) => h("li", {}, `${number(one.elapsed_s)} s: ${one.error}`)))] : null,
      h("h4", {}, "Prompt"), (call.messages || []).map((message) => [
        h("p", {class: "role"}, message.role,
          message.images_sha256 ? ` · ${message.images_sha256.length} image(s) ${message.images_sha256.map((one) => one.slice(0, 12)).join(", ")}` : null),
        prompt(message.content)]),
      facts([["model", call.model], ["host", call.host], ["sampling seed", String(call.seed)], ["times", seconds(call.timings)],
        ["tokens", `${number(call.prompt_tokens)} in${call.cached_tokens === null || call.cached_tokens === undefined ? "" : ` (${number(call.cached_tokens)} from the server's prompt cache)`}, ${number(call.output_tokens)} out`],
        ["parameters", quote(JSON.stringify(call.parameters, null, 1), "small")]]));
  }

  /** What was told to an agent. */
  function told(received) {
    return received.length ? [h("h4", {}, "Was told"), h("ul", {class: "told"}, received.map(([, sender, text]) => h("li", {}, h("b", {}, `${sender}: `), h("bdi", {}, text))))] : null;
  }

  /** Keep in `opened` which calls somebody opened, so that they stay open from step to step. */
  function keepOpen(element, opened) {
    element.addEventListener("click", (event) => {
      const call = event.target.closest("summary")?.parentElement, key = call?.dataset.key;
      if (!key) return;
      if (call.open) opened.delete(key); else opened.add(key);
    });
  }

  /** Return the calls with the one that failed first open; nothing is hidden about a failed decision. */
  function calls(data, decision, opened) {
    if (decision.damaged) return [h("p", {class: "warning"}, `The log of calls cannot be read to its end: ${decision.damaged}`)];
    if (!decision.calls.length) return [h("p", {class: "note"}, "The log holds no call of this step.")];
    const asked = new Map(), failed = (...question) => !["chosen", undefined].includes(data.form.outcome(decision, ...question));
    return decision.calls.map((call) => {
      const {kind} = call, before = asked.get(kind) ?? 0;
      asked.set(kind, before + 1);
      return callView(call, before, opened.has(keyOf(kind, before)) || failed(kind, before));
    });
  }

  class Inspector {
    /** @param onSelect called with an agent's number or null */
    constructor(data, onSelect) {
      this.data = data;
      this.onSelect = onSelect;
      this.agent = null;
      this.opened = new Set();
      this.choice = h("select", {"aria-label": "Agent", onchange: () => onSelect(this.choice.value === "" ? null : Number(this.choice.value))});
      this.offer();
      this.persona = h("p", {class: "persona"});
      this.body = h("div", {class: "decision"});
      this.element = h("section", {class: "inspector", "aria-label": "What the agent did"}, h("div", {class: "row"}, h("h2", {}, "Agent"), this.choice), this.persona, this.body);
      keepOpen(this.body, this.opened);
    }

    /** Offer every agent that is known by now. */
    offer() {
      const {agents} = this.data.about;
      if (this.offered === agents) return;
      this.offered = agents;
      fill(this.choice, h("option", {value: ""}, "no agent"), Array.from({length: agents}, (_, agent) => h("option", {value: String(agent)}, `agent ${agent}`)));
      this.choice.value = this.agent === null ? "" : String(this.agent);
    }

    select(agent, track) {
      this.agent = agent;
      this.choice.value = agent === null ? "" : String(agent);
      const persona = track && Object.entries(track.persona || {});
      fill(this.persona, persona && persona.length ? persona.map(([name, value]) => `${name}: ${value}`).join(", ")
        : agent === null ? "Choose an agent here, or click one." : track ? "Its records state no persona." : "");
      this.shown = null;
    }

    /**
     * Show a step of the chosen agent; asks for its records when they are not there.
     * @param remarkable what to show when no agent is chosen: [what, agents] of this step
     */
    async show(step, remarkable) {
      const wanted = `${this.agent}/${step}/${this.data.done}/${remarkable ? remarkable.length : ""}`;
      if (this.shown === wanted) return;
      this.shown = wanted;
      if (this.agent === null || !step) { fill(this.body, this.whose(step, remarkable || [])); return; }
      setTimeout(() => { if (this.shown === wanted && this.filled !== wanted) fill(this.body, h("p", {class: "note"}, "Loading\u2026")); }, PATIENCE_MS);
      try {
        const decision = await this.data.decision(step, this.agent);
        if (this.shown === wanted) this.fillBody(step, decision);
      } catch (error) {
        if (this.shown === wanted) fill(this.body, h("p", {class: "warning"}, error.message));
      }
    }

    /** Return buttons for the agents of a step whose decisions are worth a look. */
    whose(step, remarkable) {
      return remarkable.map(([what, agents]) => [h("h4", {}, `Step ${step}: ${what} (${agents.length})`),
        h("p", {}, agents.slice(0, LISTED).map((agent) => h("button", {type: "button", class: "go", "aria-label": `Agent ${agent}`, onclick: () => { this.onSelect(agent); this.choice.focus({preventScroll: true}); }}, String(agent))),
          agents.length > LISTED ? " \u2026" : null)]);
    }

    fillBody(step, decision) {
      this.filled = this.shown;
      fill(this.body, h("h3", {}, `Step ${step}`), decision.record ? this.data.form.decision(decision) : h("p", {class: "note"}, "No decision of it is recorded at this step."),
        h("h3", {}, "Prompts and replies"), calls(this.data, decision, this.opened));
    }
  }

  foundry.Inspector = Inspector;
  foundry.parts = {facts, calls, keepOpen, told};
})(window.Foundry);
