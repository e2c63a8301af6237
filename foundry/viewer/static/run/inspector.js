"use strict";
/* The agents of a run, one row each, or one agent at a step: its messages, thoughts, actions, prompts and replies. */
(function (foundry) {
  const {h, fill, badge, quote, number} = foundry.dom;
  const PATIENCE_MS = 300;
  const LAST = 5;

  function facts(pairs) {
    return h("dl", {class: "facts"}, pairs.filter((pair) => pair && pair[1] !== null && pair[1] !== undefined && pair[1] !== "")
      .map(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]));
  }

  function seconds(timings) {
    return Object.entries(timings || {}).map(([name, value]) => `${name} ${number(value)} s`).join(", ");
  }

  /** A prompt exactly as it was sent. If it has headings, its sections can be folded. */
  function prompt(text) {
    const parts = foundry.words.sections(text);
    if (parts.length < 2) return quote(text, "prompt");
    return parts.map(([heading, body]) => (heading ? h("details", {class: "section", open: true}, h("summary", {}, h("bdi", {}, heading)), quote(body, "prompt")) : quote(body, "prompt")));
  }

  /** Return a key of a call within its step: its kind, and the number of earlier calls of this kind. */
  function keyOf(kind, before) { return JSON.stringify([kind, before]); }

  /** One call: the prompt exactly as it was sent, the raw reply, and the details of the call. */
  function callView(call, before, open) {
    const attempts = call.attempts || [];
    return h("details", {class: "call", open, "data-kind": call.kind, "data-key": keyOf(call.kind, before)},
      h("summary", {}, h("b", {}, call.kind), ` · ${call.cached ? "from the cache" : "from the model"} · finish reason: ${call.ending}`),
      h("h4", {}, "Reply"), quote(call.text, "reply"),
      call.thinking ? [h("h4", {}, "Thinking"), quote(call.thinking)] : null,
      attempts.length ? [h("h4", {}, "Failed attempts"), h("ul", {}, attempts.map((error) => h("li", {}, `${number(error.elapsed_s)} s: ${error.error}`)))] : null,
      h("h4", {}, "Prompt"), (call.messages || []).map((message) => [
        h("p", {class: "role"}, message.role,
          message.images_sha256 ? ` · ${message.images_sha256.length} image(s) ${message.images_sha256.map((hash) => hash.slice(0, 12)).join(", ")}` : null),
        prompt(message.content)]),
      facts([["model", call.model], ["host", call.host], ["sampling seed", String(call.seed)], ["times", seconds(call.timings)],
        ["tokens", `${number(call.prompt_tokens)} in${call.cached_tokens === null || call.cached_tokens === undefined ? "" : ` (${number(call.cached_tokens)} from the server's prompt cache)`}, ${number(call.output_tokens)} out`],
        ["parameters", quote(JSON.stringify(call.parameters, null, 1), "small")]]));
  }

  /** The messages to an agent at the step and before. Each line has a link to the sender's moment. */
  function inbox({received, before, since, momentOf}) {
    const heard = (lines, when) => h("ul", {class: "told"}, lines.map(([step, sender, text]) =>
      h("li", {}, h("a", {href: momentOf(step, sender), "data-sender": String(sender)}, `${when ? `step ${step}, ` : ""}agent ${sender}`), ": ", h("bdi", {}, text))));
    const earlier = before.slice(0, -LAST);
    return [received.length ? [h("h4", {}, "Messages received"), heard(received, false)] : null,
      before.length ? [h("h4", {}, `Messages received earlier, since step ${since}`), heard(before.slice(-LAST), true)] : null,
      earlier.length ? h("details", {}, h("summary", {}, `${earlier.length} before these`), heard(earlier, true)) : null];
  }

  /** Return the reasons that an agent gave, each under its heading; if it gave none, the thinking of the model. */
  function thought(reasons, calls = []) {
    const given = reasons.filter(([, text]) => text);
    const thoughts = given.length ? given : calls.filter((call) => call.thinking).map((call) => [`Thought (${call.kind})`, call.thinking]);
    return thoughts.map(([head, text]) => [h("h4", {}, head), quote(text)]);
  }

  /** Remember in `opened` which calls the user has opened, so that they stay open from step to step. */
  function keepOpen(element, opened) {
    element.addEventListener("click", (event) => {
      const call = event.target.closest("summary")?.parentElement, key = call?.dataset.key;
      if (!key) return;
      if (call.open) opened.delete(key); else opened.add(key);
    });
  }

  /** Return the calls. The failed call is open, so that nothing about a failed decision is hidden. */
  function calls(data, decision, opened) {
    if (decision.damaged) return [h("p", {class: "warning"}, `The log of calls cannot be read to its end: ${decision.damaged}`)];
    if (!decision.calls.length) return [h("p", {class: "note"}, "The log has no call of this step.")];
    const asked = new Map(), failed = (...question) => !["chosen", undefined].includes(data.form.outcome(decision, ...question));
    return decision.calls.map((call) => {
      const {kind} = call, before = asked.get(kind) ?? 0;
      asked.set(kind, before + 1);
      return callView(call, before, opened.has(keyOf(kind, before)) || failed(kind, before));
    });
  }

  class Inspector {
    /**
     * @param onSelect called with the number of an agent, or null
     * @param onStep called with the step to go to
     * @param decided as for Agents
     */
    constructor(data, onSelect, onStep, decided) {
      this.data = data;
      this.onSelect = onSelect;
      this.onStep = onStep;
      this.agents = new foundry.Agents(data, onSelect, decided);
      this.all = h("input", {type: "checkbox", onchange: () => { this.shown = null; this.show(this.step); }});
      this.allLabel = h("label", {hidden: true}, this.all, " all steps");
      this.agent = null;
      this.opened = new Set();
      this.choice = h("select", {"aria-label": "Agent", onchange: () => onSelect(this.choice.value === "" ? null : Number(this.choice.value))});
      this.offer();
      this.persona = h("p", {class: "persona"});
      this.body = h("div", {class: "decision"});
      this.element = h("section", {class: "inspector", "aria-label": "What the agent did"}, h("div", {class: "row"}, h("h2", {}, "Agent"), this.allLabel, this.choice), this.persona, this.body);
      this.body.addEventListener("click", (event) => this.followed(event));
      keepOpen(this.body, this.opened);
    }

    /** Offer all agents that are loaded so far. */
    offer() {
      const {agents} = this.data.about;
      if (this.offered === agents) return;
      this.offered = agents;
      fill(this.choice, h("option", {value: ""}, "no agent"), Array.from({length: agents}, (_, agent) => h("option", {value: String(agent)}, `agent ${agent}`)));
      this.choice.value = this.agent === null ? "" : String(this.agent);
    }

    /** Stay on this page if a link leads to another moment of the same run. */
    followed(event) {
      const link = event.target.closest("[data-sender]");
      if (!link || event.ctrlKey || event.metaKey || event.shiftKey) return;
      event.preventDefault();
      const step = new URLSearchParams(link.hash.split("?")[1]).get("step");
      this.onSelect(Number(link.dataset.sender));
      this.onStep(Number(step));
    }

    select(agent, track) {
      this.agent = agent;
      this.allLabel.hidden = agent === null;
      this.choice.value = agent === null ? "" : String(agent);
      const persona = track && Object.entries(track.persona || {});
      fill(this.persona, persona && persona.length ? persona.map(([name, value]) => `${name}: ${value}`).join(", ")
        : agent === null ? "" : track ? "The records contain no persona of this agent." : "");
      this.shown = null;
    }

    /** Show a step of the chosen agent, or of all agents if none is chosen; load missing records. */
    async show(step) {
      const wanted = `${this.agent}/${step}/${this.data.done}`;
      this.step = step;
      if (this.shown === wanted) return;
      this.shown = wanted;
      if (this.agent === null || !step) { await this.showAgents(step); return; }
      if (this.all.checked) { await this.showAll(step); return; }
      setTimeout(() => { if (this.shown === wanted && this.filled !== wanted) fill(this.body, h("p", {class: "note"}, "Loading\u2026")); }, PATIENCE_MS);
      try {
        const decision = await this.data.decision(step, this.agent);
        if (this.shown === wanted) this.fillBody(step, decision);
      } catch (error) {
        if (this.shown === wanted) fill(this.body, h("p", {class: "warning"}, error.message));
      }
    }

    async showAgents(step) {
      if (!this.agents.element.isConnected) fill(this.body, this.agents.element);
      if (!step) return;
      await Promise.all([this.agents.show(step), this.agents.load()]).catch((error) => fill(this.body, h("p", {class: "warning"}, error.message)));
    }

    /** Show the messages, thoughts and actions of the agent at all steps, as one conversation. */
    async showAll(step) {
      const {agent, data} = this, key = `${agent}/${data.done}`;
      if (this.talkOf !== key || !this.talk.isConnected) {
        this.talkOf = key;
        this.talk = h("ol", {class: "talk"});
        fill(this.body, this.talk);
        for (let at = 1; at <= data.done && this.talkOf === key && this.all.checked; at += 1) {
          const decision = await data.decision(at, agent);
          if (this.agent === agent && decision.record) this.talk.append(this.turn(at, decision));
        }
      }
      this.talk.querySelector(".now")?.classList.remove("now");
      const now = this.talk.querySelector(`[data-step="${this.step ?? step}"]`);
      now?.classList.add("now");
      now?.scrollIntoView({block: "nearest"});
    }

    turn(step, decision) {
      const {thoughts, did, said} = this.data.form.gist(decision), line = (name, text) => h("p", {}, h("small", {}, `${name} `), text);
      const senders = decision.received.map(([at, sender, text]) =>
        line("message from", [h("a", {href: decision.momentOf(at, sender), "data-sender": String(sender)}, `agent ${sender}`), ": ", h("bdi", {}, text)]));
      return h("li", {"data-step": String(step)}, h("button", {type: "button", class: "go", onclick: () => this.onStep(step)}, `step ${step}`),
        senders, thoughts.filter(Boolean).map((text) => line("thought", h("bdi", {}, text))), line("did", h("bdi", {}, did)),
        said === null ? null : line("said", h("q", {}, h("bdi", {}, said))));
    }

    fillBody(step, decision) {
      this.filled = this.shown;
      fill(this.body, h("h3", {}, `Step ${step}`), decision.record ? this.data.form.decision(decision) : h("p", {class: "note"}, "No decision of this agent is recorded at this step."),
        h("h3", {}, "Prompts and replies"), calls(this.data, decision, this.opened));
    }
  }

  foundry.Inspector = Inspector;
  foundry.parts = {facts, calls, keepOpen, inbox, thought};
})(window.Foundry);
