"""Persona effect: the share of actions that goes with each attribute of personas, beyond shuffled personas."""

from __future__ import annotations

from analysis.any.any_run import AnyRun
from analysis.any.decided import decided
from analysis.any.group_patterns import effect, means
from analysis.measure import Measure, Null, share

NAME = "persona_effect"

PRIMARY = False

MEASURES = {
    "n_agents": Measure("Agents that are compared", low=0),
    "p_*": share("Shuffles in which as much goes with * (share)"),
    "*": Measure(
        "Actions that go with *, beyond shuffled personas (share)",
        null=Null(0, "acts without regard to its persona, whatever its habits"),
        says="acts {more|less} by the * of its persona",
    ),
}

HEADLINE = ("*",)


def measure(run: AnyRun) -> dict[str, float]:
    """Return what goes with the attributes of the personas of a run, in the counted actions.

    Actions and moments are those of `heterogeneity`: an agent's action is held against those of the other agents at
    the same moment. What is shuffled within the run is the attribute among the agents. An agent's actions stay
    together, all of them in their order, so neither habits nor what all do at a step look like an effect; if personas
    are drawn without regard to anything else, the test is exact, whatever the agents do.

    - <attribute>: sum of squares between the groups with the same value of the attribute, of the agents' mean actions,
      each agent counting the same, less its mean over all shuffles, (G - 1) / (N - 1) of that between the agents for
      N agents in G groups; over the part 1 - (G - 1) / (N - 1) that groups could have beyond that, and over N - 1. It
      is a share of the variance of actions at a moment, as in `heterogeneity`, so that the two can be held against
      each other, and runs of different length, too. 0: personas make no difference; 1: the attribute alone decides,
      at all steps alike; below 0, or
      above 1 where few decide now and then, by chance. Attributes that go together show each other's effects.
    - p_<attribute>: share of the shuffles, the run as it is among them, in which as much goes with the attribute, or
      more: of all N! for up to six agents, else of 1,000, 999 of them random; 0..1.

    NaN where all or no two agents have the same value, and where all always act alike. Agents that are asked different
    kinds of questions are not compared; kinds together weigh by their decisions. Denominator: n_agents, with a persona
    and actions beside others'.

    Source: Kelley 1935 (epsilon squared) for the share beyond chance; Pitman 1937 for the shuffles.
    """
    did = means(decided(run), run.agents)
    named = {agent for members in did.classes for agent in members.tolist() if run.personas[agent]}
    found = {"n_agents": float(len(named))}
    for attribute in dict.fromkeys(name for persona in run.personas for name in persona):
        groups = {agent: persona[attribute] for agent, persona in enumerate(run.personas) if attribute in persona}
        one = effect(did, groups)
        found |= {attribute: one.share, f"p_{attribute}": one.p}
    return found
