"""Persona effect: how much each attribute of the personas explains of the actions, beyond shuffled personas."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.any.decided import DecisionsOfKind, decided
from analysis.any.deviations import deviations, scaled, variance
from analysis.any.shuffles import classes_of, over_shuffles, p_value
from analysis.arrays import FloatArray, IntArray
from analysis.formulas import ratio
from analysis.measure import Measure, Null, share


@dataclass(frozen=True)
class Effect:
    """The part of the differences between agents' actions that the groups of the agents explain.

    Attributes:
        share: explained share of the variance of decisions at a moment, minus its mean for shuffled groups. NaN if
            nothing varies, if all agents are in one group, or if each is in its own.
        p: share of shuffles, the actual groups included, that explain at least as much as the actual groups.
    """

    share: float
    p: float


@dataclass(frozen=True)
class Means:
    """How far each agent's actions deviate, on average over a run, from the other agents' actions at the same moments.

    Attributes:
        values: mean deviation in units of the standard deviation of decisions at a moment, (N, C); C columns for all
            kinds together.
        classes: ids of the agents that were asked the same kinds of questions, at least two per class.
    """

    values: FloatArray
    classes: tuple[IntArray, ...]


def means(kinds_decided: Sequence[DecisionsOfKind], agents: int) -> Means:
    """Return how far each of N agents deviates from the others; a kind with more decisions weighs more."""
    values, able, counts = [], [], []
    for decisions in map(scaled, kinds_decided):
        whole = deviations(decisions, decisions.moment, agents)
        chance = variance(whole)
        if chance > 0:
            # The mean at a moment includes an agent's own decisions, so the agent seems nearer to it than it is.
            sums, is_able = whole.sums * (1 - ratio(1, int(whole.able.sum()))), whole.able[:, None]
            means_of = np.divide(sums, whole.weights[:, None], out=np.zeros_like(sums), where=is_able)
            values.append(means_of / np.sqrt(chance))
            able.append(whole.able)
            counts.append(np.where(whole.able, np.bincount(decisions.agent, minlength=agents), 0))
    if not values:
        return Means(np.zeros((agents, 0)), ())
    classes = tuple(classes_of(np.column_stack(able)))
    for members in classes:
        every = sum(int(count[members].sum()) for count in counts)
        for value, count in zip(values, counts, strict=True):
            value[members] *= math.sqrt(count[members].sum() / every)
    return Means(np.hstack(values), classes)


def effect(of: Means, groups: Mapping[int, str]) -> Effect:
    """Return how much of the agents' deviations the groups explain; `groups` maps agent ids to groups.

    The agents' whole runs are shuffled, so dependence from step to step stays intact. Each agent is compared with the
    others at the same moments, so common behaviour cancels out.
    """
    members = ([agent for agent in rows.tolist() if agent in groups] for rows in of.classes)
    parts = [_sorted(of.values[member], [groups[agent] for agent in member]) for member in members]
    parts = [part for part in parts if part.has_groups]
    if not parts:
        return Effect(math.nan, math.nan)
    free = sum(len(part.values) for part in parts) - len(parts)
    shuffled = np.sum(
        [over_shuffles(group.between, len(parts), number, len(group.values)) for number, group in enumerate(parts)],
        axis=0,
    )
    return Effect(float(shuffled[0]) / free, p_value(shuffled))


@dataclass(frozen=True)
class _Grouped:
    """The agents of one class (asked the same kinds of questions), sorted by group.

    Attributes:
        values: values of the agents minus the mean of the class, (n, C).
        sizes: sizes of the groups, (G,).
    """

    values: FloatArray
    sizes: IntArray

    @property
    def has_groups(self) -> bool:
        """True if there are at least two groups, and if some group has several agents."""
        return 1 < len(self.sizes) < len(self.values)

    def between(self, orders: IntArray) -> FloatArray:
        """Return, for each of r orders of the agents, how much more the groups explain than shuffled groups, (r,).

        Let S be the sum of squares of n agents. Shuffled groups explain (G - 1) / (n - 1) of S on average. The excess
        is divided by the remaining share of S, so that groups that explain everything get S.

        Args:
            orders: orders of the agents, (r, n).
        """
        starts = np.concatenate(([0], np.cumsum(self.sizes)[:-1]))
        sums = np.add.reduceat(self.values[orders], starts, axis=1)
        sums_of_squares = (sums**2 / self.sizes[:, None]).sum(axis=(1, 2))
        by_chance = (len(self.sizes) - 1) / (len(self.values) - 1)
        return np.asarray((sums_of_squares - by_chance * float((self.values**2).sum())) / (1 - by_chance))


def _sorted(values: FloatArray, groups: Sequence[str]) -> _Grouped:
    number, sizes = np.unique(np.array(groups, dtype=np.str_), return_inverse=True, return_counts=True)[1:]
    mean = values.mean(axis=0) if len(values) else 0.0
    return _Grouped((values - mean)[np.argsort(number, kind="stable")], sizes)


NAME = "persona_effect"

PRIMARY = False

MEASURES = {
    "n_agents": Measure("Agents that are compared", low=0),
    "p_*": share("Shuffles in which * explains as much (share)"),
    "*": Measure(
        "Variance of actions explained by *, minus that of shuffled personas (share)",
        null=Null(0, "acts independently of its persona, whatever its habits"),
        says="follows the * of its persona {more|less}",
    ),
}

HEADLINE = ("*",)


def measure(run: AnyRun) -> dict[str, float]:
    """Return how much of the variation in a run's counted actions is explained by the attributes of the personas.

    Actions and moments are as in `heterogeneity`: each action is compared with the other agents' actions at the same
    moment. Each shuffle assigns the values of the attribute to the agents of the run at random. An agent's sequence of
    actions stays intact, so neither habits nor common behaviour look like an effect. If personas are drawn
    independently of everything else, the test is exact for any behaviour.

    - <attribute>: let B be the sum of squares between the G groups with equal values of the attribute, over the mean
      actions of N agents of equal weight. The measure is B minus its mean over all shuffles, which is (G - 1) / (N - 1)
      of the sum of squares between agents. The difference is divided by 1 - (G - 1) / (N - 1), the largest possible
      excess, and by N - 1. The result is a share of the variance of actions at a moment, as in `heterogeneity`. So you
      can compare the two signatures, and also runs of different length. 0: personas make no difference; 1: the
      attribute alone decides, always in the same way. Chance can give values below 0, or above 1 if agents decide
      rarely. If attributes are correlated, each shows effects of the others.
    - p_<attribute>: share of shuffles, the actual run included, in which the attribute explains at least as much as in
      the actual run; 0..1. Up to six agents, all N! shuffles are taken; else 999 random ones and the actual run.

    NaN if all agents have the same value, if no two agents do, or if all agents always act alike. Only agents that are
    asked the same kinds of questions are compared; each kind weighs by its number of decisions. Denominator: n_agents,
    the agents that have a persona and that act in the same steps as at least one other agent.

    Source: Kelley 1935 (epsilon squared) for the share beyond chance; Pitman 1937 for the shuffles.
    """
    did = means(decided(run), run.agents)
    named = {agent for members in did.classes for agent in members.tolist() if run.personas[agent]}
    measures = {"n_agents": float(len(named))}
    for attribute in dict.fromkeys(name for persona in run.personas for name in persona):
        groups = {agent: persona[attribute] for agent, persona in enumerate(run.personas) if attribute in persona}
        effect_of = effect(did, groups)
        measures |= {attribute: effect_of.share, f"p_{attribute}": effect_of.p}
    return measures
