"use strict";
/* Finds where runs part: the first step at which an action differs, and the first at which a text does. */
(function (foundry) {
  /** Return the agents that did not do the same in all runs at a step. */
  async function differingAgents(runs, step) {
    const chunks = await Promise.all(runs.map((run) => run.load(step)));
    const agents = Math.max(...runs.map((run) => run.about.agents)), found = [];
    for (let agent = 0; agent < agents; agent += 1) {
      const keys = runs.map((run, index) => {
        if (agent >= run.about.agents || step > chunks[index].last) return "none";
        return run.form.same(chunks[index], run.about, step, agent);
      });
      if (new Set(keys).size > 1) found.push(agent);
    }
    return found;
  }

  /** Return {step, agents} of the first difference in what was done; null when there is none in the steps all runs have. */
  async function firstDifference(runs, stopped) {
    const last = Math.min(...runs.map((run) => run.done));
    for (let step = 1; step <= last; step += 1) {
      if (stopped()) return null;
      const agents = await differingAgents(runs, step);
      if (agents.length) return {step, agents};
    }
    return null;
  }

  function bySpeaker(texts) { return new Map(texts.map(([step, agent, text]) => [`${step}/${agent}`, text])); }

  /** Return {step, agents} of the first difference in what was said; null when there is none. */
  async function firstText(runs, stopped) {
    const last = Math.min(...runs.map((run) => run.done)), size = Math.min(...runs.map((run) => run.about.steps_per_chunk));
    if (new Set(runs.map((run) => run.about.steps_per_chunk)).size > 1) return null;
    for (let chunk = 0; chunk * size < last && !stopped(); chunk += 1) {
      const said = await Promise.all(runs.map(async (run) => bySpeaker((await run.texts(chunk)).texts)));
      const differing = [...new Set(said.flatMap((one) => [...one.keys()]))].filter((key) => new Set(said.map((one) => one.get(key))).size > 1)
        .map((key) => key.split("/").map(Number)).filter(([step]) => step <= last);
      if (differing.length) {
        const step = Math.min(...differing.map((one) => one[0]));
        return {step, agents: differing.filter((one) => one[0] === step).map((one) => one[1]).sort((a, b) => a - b)};
      }
    }
    return null;
  }

  foundry.difference = {differingAgents, firstDifference, firstText};
})(window.Foundry);
