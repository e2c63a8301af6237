"use strict";
/* Finds the agents that acted differently in different runs, and the first step with such an agent. */
(function (foundry) {
  /** Return the agents whose actions at a step differ between the runs that have this step and this agent. */
  async function differingAgents(all, step) {
    const runs = all.filter((run) => step <= run.done), chunks = await Promise.all(runs.map((run) => run.load(step)));
    const agents = runs.reduce((most, run) => Math.max(most, run.about.agents), 0), apart = [];
    for (let agent = 0; agent < agents; agent += 1) {
      const keys = runs.map((run, index) => (agent < run.about.agents ? run.form.same(chunks[index], run.about, step, agent) : null));
      if (new Set(keys.filter((key) => key !== null)).size > 1) apart.push(agent);
    }
    return apart;
  }

  /** Return {step, agent} of the first difference between two runs, or null if there is none. */
  async function firstDifference(runs, stopped) {
    for (let step = 1; runs.filter((run) => step <= run.done).length > 1 && !stopped(); step += 1) {
      const [agent] = await differingAgents(runs, step);
      if (agent !== undefined) return {step, agent};
    }
    return null;
  }

  foundry.difference = {differingAgents, firstDifference};
})(window.Foundry);
