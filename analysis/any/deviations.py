"""How agents differ from the others that decide at the same moment: what all do alike at a moment drops out.

N agents; C columns of values, as in `analysis.any.decided`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.any.decided import Decided, beyond
from analysis.arrays import BoolArray, FloatArray, IntArray
from analysis.formulas import ratio


@dataclass(frozen=True)
class Deviations:
    """How the values of agents differ from the means of their moments.

    Attributes:
        sums: over an agent's decisions, value less the mean of its moment, (N, C).
        weights: their variance where all draw alike with variance 1, (N,): summed over an agent's moments, the number
            of its decisions times the share of the decisions there that are not its own. 0 for who is always alone.
        differences: over the pairs of decisions of two agents at one moment, half the square of the difference of
            their values, summed; of labels that is the number of pairs that differ.
        pairs: number of these pairs.
    """

    sums: FloatArray
    weights: FloatArray
    differences: float
    pairs: float

    @property
    def able(self) -> BoolArray:
        """Which agents can be compared with others, (N,)."""
        return self.weights > 0


def variance(*found: Deviations) -> float:
    """Return the variance of decisions at one moment, from pairs of two agents; NaN where there are none."""
    return ratio(sum(one.differences for one in found), sum(one.pairs for one in found))


def scaled(one: Decided) -> Decided:
    """Return the decisions with numbers brought between -2 and 2, which changes no comparison and cannot overflow."""
    if one.labels:
        return one
    size = np.abs(one.values).max(initial=0)
    values = one.values / size if size else one.values
    return Decided(one.kind, one.labels, one.step, one.agent, values - values[:1])


def thirds(one: Decided) -> tuple[BoolArray, BoolArray]:
    """Return which decisions (n,) are in the first and in the last third of the steps that have any.

    Both have as many steps, one at least. With fewer than two steps there are none.
    """
    length = max(1, one.steps // 3) if one.steps > 1 else 0
    return one.rank < length, one.rank >= max(one.steps - length, length)


def deviations(one: Decided, moment: IntArray, agents: int) -> Deviations:
    """Return how the agents differ from the others.

    Args:
        one: n decisions of one kind.
        moment: of each of them, (n,).
        agents: number of agents, N.
    """
    codes, cell = np.unique(moment * beyond(one.agent) + one.agent, return_inverse=True)
    at, who = np.divmod(codes, beyond(one.agent))
    # Number, sum and sum of squares of the decisions of each agent at each moment, and of all agents there.
    own = np.column_stack([np.ones(len(cell)), one.values, (one.values**2).sum(axis=1)])
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
    """Return the sums of rows (n, k) by their group (n,), (groups, k)."""
    width = rows.shape[1]
    places = (group[:, None] * width + np.arange(width)).ravel()
    found = np.bincount(places, weights=rows.ravel(), minlength=groups * width)
    return np.asarray(found, dtype=np.float64).reshape(groups, width)


def _spread(totals: FloatArray) -> float:
    """Return the sum of the squares of the differences in all pairs of each group; totals (groups, 1 + C + 1)."""
    return float((totals[:, 0] * totals[:, -1] - (totals[:, 1:-1] ** 2).sum(axis=1)).sum())
