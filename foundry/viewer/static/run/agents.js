"use strict";
/* The agents of a run, one row each, with their actions and messages at a step, and totals over the whole run for sorting. */
(function (foundry) {
  const {h, fill, number, badge} = foundry.dom;
  const SAID = 60, ROWS = 100;
  /** Return the rank of an outcome in the display: failures come first. */
  const rank = (outcome) => ({chosen: 2, repaired: 1}[outcome] ?? 0);
  const short = (text) => (text.length > SAID ? `${text.slice(0, SAID)}…` : text);

  class Agents {
    /**
     * @param onSelect called with the number of an agent
     * @param decided returns the decisions at a step by agent: {action, said, outcomes}; null while they are loading
     */
    constructor(data, onSelect, decided) {
      Object.assign(this, {data, onSelect, decided, totals: [], sort: null, down: true, limit: ROWS});
      this.head = h("tr");
      this.body = h("tbody");
      this.more = h("button", {type: "button", onclick: () => { this.limit += ROWS; this.draw(); }}, "more agents");
      this.element = h("div", {class: "agents", tabindex: "0", role: "region", "aria-label": "Agents"},
        h("table", {class: "runs"}, h("caption", {class: "unseen"}, "Agents at the step"), h("thead", {}, this.head), this.body), this.more);
    }

    /** Load the totals of the agents over the run so far. */
    async load() {
      if (this.loaded === this.data.done) return;
      this.loaded = this.data.done;
      this.totals = (await this.data.once("agents")).agents;
      this.draw();
    }

    async show(step) {
      this.step = step;
      const rows = await this.decided(step);
      if (this.step !== step || !rows) return;
      this.rows = rows;
      this.draw();
    }

    /** Return the names of the totals. */
    counts() { return Object.keys(this.totals[0]?.counts || {}).filter((name) => name !== "messages" || this.speaks()); }

    /** Return whether any agent has said anything so far. */
    speaks() { return this.totals.some(({counts}) => counts.messages); }

    /**
     * Return the agents in their order. Unless they are sorted by a total, agents with a failed or repaired decision in
     * this step come first.
     */
    ordered() {
      const agents = Array.from({length: this.data.about.agents}, (_, agent) => agent), count = (agent) => this.totals[agent]?.counts[this.sort] ?? -Infinity;
      if (this.sort === null) return agents.sort((a, b) => rank(this.worst(a)) - rank(this.worst(b)) || a - b);
      return agents.sort((a, b) => (this.down ? count(b) - count(a) : count(a) - count(b)) || a - b);
    }

    /** Return the outcome to show for an agent's decisions in the step: a failure before a repair. */
    worst(agent) { return (this.rows?.get(agent)?.outcomes || []).reduce((a, b) => (rank(b) < rank(a) ? b : a), "chosen"); }

    draw() {
      const counts = this.counts(), agents = this.ordered();
      fill(this.head, this.title(null, "agent"), ["did", ...this.speaks() ? ["said"] : []].map((name) => h("th", {scope: "col"}, name)), counts.map((name) => this.title(name, name)));
      fill(this.body, agents.slice(0, this.limit).map((agent) => this.row(agent, counts)));
      this.more.hidden = agents.length <= this.limit;
    }

    title(key, name) {
      const sorted = this.sort === key && key !== null;
      return h("th", {scope: "col", class: key === null ? null : "number", "aria-sort": sorted ? (this.down ? "descending" : "ascending") : null},
        h("button", {type: "button", "data-sort": name, onclick: () => this.sortBy(key)}, name, sorted ? (this.down ? " ▾" : " ▴") : ""));
    }

    sortBy(key) {
      this.down = this.sort === key ? !this.down : true;
      this.sort = key;
      this.draw();
    }

    row(agent, counts) {
      const {action = "", said = null} = this.rows?.get(agent) || {}, total = this.totals[agent], worst = this.worst(agent);
      const persona = Object.values(total?.persona || {}).join(", ");
      return h("tr", {"data-agent": String(agent)},
        h("th", {scope: "row"}, h("button", {type: "button", class: "go", "aria-label": `Agent ${agent}`, onclick: () => this.onSelect(agent)}, String(agent)), persona ? h("small", {title: persona}, ` ${persona}`) : null),
        h("td", {}, action && worst === "chosen" ? "✓ " : null, worst === "chosen" ? null : [badge(worst), " "], h("bdi", {}, action)),
        this.speaks() ? h("td", {class: "said"}, said === null ? null : h("q", {}, h("bdi", {}, short(said)))) : null,
        counts.map((name) => h("td", {class: "number"}, total ? number(total.counts[name]) : "")));
    }
  }

  foundry.Agents = Agents;
})(window.Foundry);
