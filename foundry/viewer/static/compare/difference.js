"use strict";
/* Finds the agents that did not do the same in all runs, and the first step at which there are any. */
(function (foundry) {
  /** Return the agents that did not do the same in all runs that have a step. */
  async function differingAgents(all, step) {
    const runs = all.filter((run) => step <= run.done), chunks = await Promise.all(runs.map((run) => run.load(step)));
    const agents = runs.reduce((most, run) => Math.max(most, run.about.agents), 0), found = [];
    for (let agent = 0; agent < agents; agent += 1) {
      const keys = runs.map((run, index) => (agent < run.about.agents ? run.form.same(chunks[index], run.about, step, agent) : "none"));
      if (new Set(keys).size > 1) found.push(agent);
    }
    return found;
  }

  /** Return {step, agent} of the first difference in the steps that two runs have; null for none. */
  async function firstDifference(runs, stopped) {
    for (let step = 1; runs.filter((run) => step <= run.done).length > 1 && !stopped(); step += 1) {
      const [agent] = await differingAgents(runs, step);
      if (agent !== undefined) return {step, agent};
    }
    return null;
  }

  foundry.difference = {differingAgents, firstDifference};
})(window.Foundry);
