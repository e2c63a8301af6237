"""Differences between agents that last through a run, against those of shuffled agents.

A shuffled agent is the first third of one agent put together with the last third of another: two whole sequences, so
that whatever holds an agent's decisions together from step to step is kept, and the third between them is longer than
that. Each third is held against the other agents at the same moments, so what all do alike drops out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from analysis.any.decided import Decided
from analysis.any.deviations import deviations, scaled, thirds, variance
from analysis.any.shuffles import classes_of, over_shuffles, p_value
from analysis.arrays import BoolArray, FloatArray, IntArray
from analysis.formulas import ratio

ALIKE = "is like all others, in habits shorter than a third of the run"
"""Whose null it is that agents do not differ lastingly."""


@dataclass(frozen=True)
class Lasting:
    """How far agents differ lastingly.

    Attributes:
        share: of the variance of decisions at a moment, less that of shuffled agents; NaN where nothing varies.
        p: share of the shuffles, the run as it is among them, in which agents differ as much, or more.
        agents: number of agents that are compared.
    """

    share: float
    p: float
    agents: int


@dataclass(frozen=True)
class _Kind:
    """What agents do in the first and the last third, in decisions of one kind.

    Attributes:
        first: deviation in units of its standard deviation by chance, (N, C); 0 where there is none.
        last: the same.
        weights: decisions that this rests on, (N,).
        able: whether the agent can be compared with others in both thirds, (N,).
    """

    first: FloatArray
    last: FloatArray
    weights: FloatArray
    able: BoolArray


def lasting(found: Sequence[Decided], agents: int) -> Lasting:
    """Return how far agents differ lastingly in their decisions of all these kinds together."""
    kinds = [kind for one in found if (kind := _kind(scaled(one), agents)) is not None]
    if not kinds:
        return Lasting(math.nan, math.nan, 0)
    first, last = (np.hstack([getattr(kind, name) for kind in kinds]) for name in ("first", "last"))
    weights = np.sum([kind.weights for kind in kinds], axis=0)
    classes = classes_of(np.column_stack([kind.able for kind in kinds]))
    parts = [_together(first[one], last[one], len(classes), number) for number, one in enumerate(classes)]
    whole = sum(float(weights[one].sum()) * (len(one) - 1) / len(one) for one in classes)
    shuffled = np.sum(parts, axis=0)
    return Lasting(
        share=ratio(float(shuffled[0]), whole) if classes else math.nan,
        p=p_value(shuffled) if classes else math.nan,
        agents=sum(map(len, classes)),
    )


def _kind(one: Decided, agents: int) -> _Kind | None:
    """Return what agents do in decisions of a kind; None where all at a moment do the same, or nobody lasts."""
    parts = [deviations(one.only(kept), one.moment[kept], agents) for kept in thirds(one)]
    chance = variance(*parts)
    able = parts[0].able & parts[1].able
    if not chance > 0 or able.sum() < 2:
        return None
    # The mean at a moment holds an agent's own decisions, too, which makes it seem nearer to the others than it is.
    unit = np.sqrt(chance) / (1 - ratio(1, int(able.sum())))
    first, last = (
        np.divide(part.sums, np.sqrt(part.weights)[:, None] * unit, out=np.zeros_like(part.sums), where=able[:, None])
        for part in parts
    )
    return _Kind(first, last, np.where(able, np.sqrt(parts[0].weights * parts[1].weights), 0.0), able)


def _together(first: FloatArray, last: FloatArray, classes: int, number: int) -> FloatArray:
    """Return how the thirds of the agents of a class go together, as they are and shuffled, less the mean, (R,)."""
    by_chance = float((first.sum(axis=0) * last.sum(axis=0)).sum()) / len(first)
    products = (first @ last.T).ravel()
    own = np.arange(len(first)) * len(first)

    def product(rows: IntArray) -> FloatArray:
        return np.asarray(products[own + rows].sum(axis=1) - by_chance)

    return over_shuffles(product, classes, number, len(first))
