"use strict";
/* Finds where runs part: the first step at which an action differs, and the first at which a text does. */
(function (foundry) {
  /** Return those of some runs that have a step. */
  function having(runs, step) { return runs.filter((run) => step <= run.done); }

  /** Return the agents that did not do the same in all runs that have a step. */
  async function differingAgents(all, step) {
    const runs = having(all, step), chunks = await Promise.all(runs.map((run) => run.load(step)));
    const agents = runs.reduce((most, run) => Math.max(most, run.about.agents), 0), found = [];
    for (let agent = 0; agent < agents; agent += 1) {
      const keys = runs.map((run, index) => (agent < run.about.agents ? run.form.same(chunks[index], run.about, step, agent) : "none"));
      if (new Set(keys).size > 1) found.push(agent);
    }
    return found;
  }

  /** Return {step, agents} of the first step, of those that two runs have, at which some agents differ; null for none. */
  async function first(runs, stopped, differing) {
    for (let step = 1; having(runs, step).length > 1 && !stopped(); step += 1) {
      const agents = await differing(step);
      if (agents.length) return {step, agents};
    }
    return null;
  }

  function firstDifference(runs, stopped) { return first(runs, stopped, (step) => differingAgents(runs, step)); }

  /** Returns what gives the texts of a run's step by agent; it keeps the chunk that was asked for last. */
  function speech(run) {
    const size = run.about.steps_per_chunk;
    let kept = null, number = -1;
    return async (step) => {
      const wanted = Math.floor((step - 1) / size);
      if (wanted !== number) [kept, number] = [(await run.texts(wanted)).texts, wanted];
      const said = new Map();
      kept.filter((one) => one[0] === step).forEach(([, agent, text]) => said.set(agent, [...(said.get(agent) || []), text]));
      return said;
    };
  }

  /** Return {step, agents} of the first difference in what was said; null when there is none. */
  function firstText(runs, stopped) {
    const speeches = new Map(runs.map((run) => [run, speech(run)]));
    return first(runs, stopped, async (step) => {
      const said = await Promise.all(having(runs, step).map((run) => speeches.get(run)(step)));
      const speakers = [...new Set(said.flatMap((one) => [...one.keys()]))].sort((a, b) => a - b);
      return speakers.filter((agent) => new Set(said.map((one) => JSON.stringify(one.get(agent)))).size > 1);
    });
  }

  foundry.difference = {differingAgents, firstDifference, firstText};
})(window.Foundry);
