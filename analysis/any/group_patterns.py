"""What goes with the groups that agents fall into, against groups that are shuffled among the agents.

A whole run of an agent is what is shuffled, so that whatever holds its decisions together is kept; and each agent is
held against the others at the same moments, so what all do alike drops out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from analysis.any.decided import Decided
from analysis.any.deviations import deviations, scaled, variance
from analysis.any.shuffles import classes_of, over_shuffles, p_value
from analysis.arrays import FloatArray, IntArray
from analysis.formulas import ratio


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
    """Return what goes with the groups of agents, by their ids; agents without a group are left out."""
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
