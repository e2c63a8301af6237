"""How far each agent's decisions deviate from the other agents' decisions at the same moment.

N is the number of agents. C is the number of labels of a decision, or 1 if the decision is a number
(`analysis.any.decided`).

Behaviour that all agents share cancels out. Lasting differences between agents are compared with the differences of
shuffled agents. A shuffled agent consists of one agent's first third of the run and another agent's last third. Within
a third, the order of decisions stays as it was, so a decision may depend on earlier ones. The middle third of the run
is not used, so the two thirds are far apart.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from analysis.any.decided import DecisionsOfKind, beyond
from analysis.any.shuffles import classes_of, over_shuffles, p_value
from analysis.arrays import BoolArray, FloatArray, IntArray
from analysis.formulas import ratio


@dataclass(frozen=True)
class Deviations:
    """How far each agent's decisions deviate from the mean decision of all agents at the same moment.

    Attributes:
        sums: decision minus the mean decision at its moment, summed over an agent's decisions, (N, C).
        weights: variance of `sums` if all agents draw from one distribution with variance 1, (N,). At each moment it is
            the number of the agent's decisions times the share of decisions by others. 0 for an agent that is always
            alone.
        differences: half the squared difference between two agents' decisions at the same moment, summed over all such
            pairs of decisions. For labels, it is the number of pairs that differ.
        pairs: number of these pairs.
    """

    sums: FloatArray
    weights: FloatArray
    differences: float
    pairs: float

    @property
    def able(self) -> BoolArray:
        """True for agents that decided at a moment at which others decided too, (N,)."""
        return self.weights > 0


def variance(*groups: Deviations) -> float:
    """Return the variance of decisions at one moment, from pairs of decisions of two agents; NaN without pairs."""
    return ratio(sum(part.differences for part in groups), sum(part.pairs for part in groups))


def scaled(decisions: DecisionsOfKind) -> DecisionsOfKind:
    """Return decisions with numbers scaled to -2..2 to prevent overflow; shares of variance stay the same."""
    if decisions.labels:
        return decisions
    size = np.abs(decisions.values).max(initial=0)
    values = decisions.values / size if size else decisions.values
    return DecisionsOfKind(decisions.kind, decisions.labels, decisions.step, decisions.agent, values - values[:1])


def thirds(decisions: DecisionsOfKind) -> tuple[BoolArray, BoolArray]:
    """Return whether each decision is in the first, and whether it is in the last third of the steps, (n,) each.

    Only steps with decisions count. Both thirds have the same number of steps, at least one. With fewer than two steps,
    both are empty.
    """
    length = max(1, decisions.steps // 3) if decisions.steps > 1 else 0
    return decisions.rank < length, decisions.rank >= max(decisions.steps - length, length)


def deviations(decisions: DecisionsOfKind, moment: IntArray, agents: int) -> Deviations:
    """Return how far each agent deviates from the others.

    Args:
        decisions: n decisions of one kind.
        moment: index of the moment of each decision, (n,).
        agents: number of agents, N.
    """
    codes, cell = np.unique(moment * beyond(decisions.agent) + decisions.agent, return_inverse=True)
    at, who = np.divmod(codes, beyond(decisions.agent))
    # Number, sum and sum of squares of the decisions of each agent at each moment, and of all agents there.
    own = np.column_stack([np.ones(len(cell)), decisions.values, (decisions.values**2).sum(axis=1)])
    own = _sums(cell, own, len(codes))
    there = _sums(at, own, beyond(at))
    number, others = own[:, 0], there[at]
    return Deviations(
        sums=_sums(who, own[:, 1:-1] - number[:, None] * others[:, 1:-1] / others[:, :1], agents),
        weights=_sums(who, (number * (1 - number / others[:, 0]))[:, None], agents)[:, 0],
        differences=(_spread(there) - _spread(own)) / 2,
        pairs=float((there[:, 0] ** 2).sum() - (number**2).sum()) / 2,
    )


def _sums(group: IntArray, rows: FloatArray, groups: int) -> FloatArray:
    """Return, for each group, the sum of its rows, (groups, k); `group`, (n,), is the group of each row."""
    width = rows.shape[1]
    places = (group[:, None] * width + np.arange(width)).ravel()
    sums = np.bincount(places, weights=rows.ravel(), minlength=groups * width)
    return np.asarray(sums, dtype=np.float64).reshape(groups, width)


def _spread(totals: FloatArray) -> float:
    """Return the sum of squared differences over all ordered pairs of two values in the same group.

    Args:
        totals: for each group, the number, the C sums and the sum of squares of its values, (groups, 1 + C + 1).
    """
    return float((totals[:, 0] * totals[:, -1] - (totals[:, 1:-1] ** 2).sum(axis=1)).sum())


ALIKE = "decides like all other agents, with any habits shorter than a third of the run"
"""The null hypothesis about an agent: it does not differ from the other agents through a whole run."""


@dataclass(frozen=True)
class LastingDifferences:
    """How far agents differ from each other through a whole run, beyond chance.

    Attributes:
        share: variance between agents that lasts through the run, as a share of the variance of decisions at a moment,
            minus its mean for shuffled agents; NaN if nothing varies.
        p: share of shuffles, the actual run included, in which agents differ at least as much as in the actual run.
        agents: number of compared agents.
    """

    share: float
    p: float
    agents: int


@dataclass(frozen=True)
class _Kind:
    """How far each agent deviates from the others in one kind of decision, in the first and last third of the run.

    Attributes:
        first: deviation in the first third, in units of its standard deviation by chance, (N, C); 0 for an agent that
            cannot be compared.
        last: the same in the last third.
        weights: weight of each agent, which grows with its number of decisions, (N,).
        able: whether the agent can be compared with others in both thirds, (N,).
    """

    first: FloatArray
    last: FloatArray
    weights: FloatArray
    able: BoolArray


def lasting(kinds_decided: Sequence[DecisionsOfKind], agents: int) -> LastingDifferences:
    """Return how far N agents differ through a whole run; `kinds_decided` holds the decisions of each kind."""
    kinds = [kind for decisions in kinds_decided if (kind := _kind(scaled(decisions), agents)) is not None]
    if not kinds:
        return LastingDifferences(math.nan, math.nan, 0)
    first, last = (np.hstack([getattr(kind, name) for kind in kinds]) for name in ("first", "last"))
    weights = np.sum([kind.weights for kind in kinds], axis=0)
    classes = classes_of(np.column_stack([kind.able for kind in kinds]))
    parts = [_together(first[members], last[members], len(classes), number) for number, members in enumerate(classes)]
    whole = sum(float(weights[rows].sum()) * (len(rows) - 1) / len(rows) for rows in classes)
    shuffled = np.sum(parts, axis=0)
    return LastingDifferences(
        share=ratio(float(shuffled[0]), whole) if classes else math.nan,
        p=p_value(shuffled) if classes else math.nan,
        agents=sum(map(len, classes)),
    )


def _kind(decisions: DecisionsOfKind, agents: int) -> _Kind | None:
    """Return the agents' deviations in one kind; None if agents never differ or fewer than two can be compared."""
    parts = [deviations(decisions.only(third), decisions.moment[third], agents) for third in thirds(decisions)]
    chance = variance(*parts)
    able = parts[0].able & parts[1].able
    if not chance > 0 or able.sum() < 2:
        return None
    # The mean at a moment includes an agent's own decisions, so the agent seems nearer to the others than it is.
    unit = np.sqrt(chance) / (1 - ratio(1, int(able.sum())))
    first, last = (
        np.divide(part.sums, np.sqrt(part.weights)[:, None] * unit, out=np.zeros_like(part.sums), where=able[:, None])
        for part in parts
    )
    return _Kind(first, last, np.where(able, np.sqrt(parts[0].weights * parts[1].weights), 0.0), able)


def _together(first: FloatArray, last: FloatArray, classes: int, number: int) -> FloatArray:
    """Return how well agents' deviations in the first and in the last third of the run agree, (R,).

    It is the sum of their products over agents, minus the mean of this sum over all shuffles. The first value is for
    the actual agents, the others are for shuffled agents.
    """
    by_chance = float((first.sum(axis=0) * last.sum(axis=0)).sum()) / len(first)
    products = (first @ last.T).ravel()
    own = np.arange(len(first)) * len(first)

    def product(rows: IntArray) -> FloatArray:
        return np.asarray(products[own + rows].sum(axis=1) - by_chance)

    return over_shuffles(product, classes, number, len(first))
