"""Persona effect: the share of actions that goes with each attribute of personas, beyond shuffled personas."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.any.decided import Decided, decided
from analysis.any.deviations import deviations, scaled, variance
from analysis.any.shuffles import classes_of, over_shuffles, p_value
from analysis.arrays import FloatArray, IntArray
from analysis.formulas import ratio
from analysis.measure import Measure, Null, share


@dataclass(frozen=True)
class Effect:
    """What goes with groups.

    Attributes:
        share: of the variance of decisions at a moment, less that of shuffled groups; NaN where nothing varies, or no
            two agents share a group or none do not.
        p: share of the shuffles, the groups as they are among them, in which as much goes with them, or more.
        agents: number of agents that are compared.
    """

    share: float
    p: float
    agents: int


@dataclass(frozen=True)
class Means:
    """What agents did over a run, against the others at the same moments.

    Attributes:
        values: mean deviation in units of the standard deviation of decisions at a moment, (N, C) over all kinds.
        classes: ids of the agents that were asked the same kinds of questions, two or more each.
    """

    values: FloatArray
    classes: tuple[IntArray, ...]


def means(found: Sequence[Decided], agents: int) -> Means:
    """Return what agents did in decisions of all these kinds; a kind weighs by the number of its decisions."""
    values, able, counts = [], [], []
    for one in map(scaled, found):
        whole = deviations(one, one.moment, agents)
        chance = variance(whole)
        if chance > 0:
            values.append(_mean_deviations(whole.sums, whole.weights) / np.sqrt(chance))
            able.append(whole.able)
            counts.append(np.where(whole.able, np.bincount(one.agent, minlength=agents), 0))
    if not values:
        return Means(np.zeros((agents, 0)), ())
    classes = tuple(classes_of(np.column_stack(able)))
    for members in classes:
        every = sum(int(count[members].sum()) for count in counts)
        for value, count in zip(values, counts, strict=True):
            value[members] *= math.sqrt(count[members].sum() / every)
    return Means(np.hstack(values), classes)


def _mean_deviations(sums: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the deviation of a decision of each agent, (N, C); 0 for who cannot be compared."""
    able = weights > 0
    # The mean at a moment holds an agent's own decisions, too, which makes it seem nearer to the others than it is.
    found = sums * (1 - ratio(1, int(able.sum())))
    return np.divide(found, weights[:, None], out=np.zeros_like(sums), where=able[:, None])


def effect(of: Means, groups: Mapping[int, str]) -> Effect:
    """Return what goes with the groups of agents, by their ids; agents without a group are left out.

    A whole run of an agent is what is shuffled, so that whatever holds an agent's decisions together from step to step
    is kept; and each agent is held against the others at the same moments, so what all do alike drops out.
    """
    members = ([agent for agent in one.tolist() if agent in groups] for one in of.classes)
    parts = [_sorted(of.values[one], [groups[agent] for agent in one]) for one in members]
    parts = [one for one in parts if one.has_groups]
    if not parts:
        return Effect(math.nan, math.nan, 0)
    agents = sum(len(one.values) for one in parts)
    free = agents - len(parts)
    shuffled = np.sum(
        [over_shuffles(one.between, len(parts), number, len(one.values)) for number, one in enumerate(parts)], axis=0
    )
    return Effect(float(shuffled[0]) / free, p_value(shuffled), agents)


@dataclass(frozen=True)
class _Grouped:
    """The agents of a class, those of one group beside one another.

    Attributes:
        values: of the agents, less the mean of the class, (n, C).
        sizes: of the groups, (G,).
    """

    values: FloatArray
    sizes: IntArray

    @property
    def has_groups(self) -> bool:
        """Whether there are two groups or more, and not each agent is one."""
        return 1 < len(self.sizes) < len(self.values)

    def between(self, orders: IntArray) -> FloatArray:
        """Return the sum of squares that goes with the groups, beyond that of shuffled ones, (r,); orders (r, n).

        Of the sum of squares S of n agents, shuffled groups have (G - 1) / (n - 1) in the mean; what remains is held
        against the part of S that groups could have beyond that, so that the whole of S is found where groups are all.
        """
        starts = np.concatenate(([0], np.cumsum(self.sizes)[:-1]))
        sums = np.add.reduceat(self.values[orders], starts, axis=1)
        found = (sums**2 / self.sizes[:, None]).sum(axis=(1, 2))
        by_chance = (len(self.sizes) - 1) / (len(self.values) - 1)
        return np.asarray((found - by_chance * float((self.values**2).sum())) / (1 - by_chance))


def _sorted(values: FloatArray, groups: Sequence[str]) -> _Grouped:
    number, sizes = np.unique(np.array(groups, dtype=np.str_), return_inverse=True, return_counts=True)[1:]
    mean = values.mean(axis=0) if len(values) else 0.0
    return _Grouped((values - mean)[np.argsort(number, kind="stable")], sizes)


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
