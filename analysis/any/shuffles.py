"""Shuffles of agents: all orders of few agents, or random orders of many, the same on every machine."""

from collections.abc import Callable, Iterator
from functools import lru_cache
from itertools import permutations

import numpy as np

from analysis.arrays import BoolArray, FloatArray, IntArray
from foundry import seeding

DRAWS = 999
"""Number of random shuffles, besides the actual order."""

FEW = 6
"""For at most this number of agents, all orders of the agents are used (at most 720); for more, random orders."""

_AT_ONCE = 1_000_000
"""Maximum number of array elements, over all orders, that are in memory at once."""


def over_shuffles(statistic: Callable[[IntArray], FloatArray], classes: int, number: int, size: int) -> FloatArray:
    """Return a statistic for R orders of a class of agents, (R,): first the actual order, then shuffled orders.

    Args:
        statistic: function of orders of the agents (r, size) that returns values (r,).
        classes: number of classes of agents in the run; if there is a single class of few agents, all orders are taken.
        number: index of this class, from which the random orders are drawn.
        size: number of agents in this class.
    """
    if classes == 1 and size <= FEW:
        return statistic(_orders(size))
    orders = _cached_blocks(number, size) if size * DRAWS <= _AT_ONCE else _blocks(number, size)
    return np.concatenate([statistic(rows) for rows in orders])


def p_value(values: FloatArray) -> float:
    """Return the p value: the share of the values (R,) that are at least as large as the first value.

    The first value is that of the actual order; the other values are those of shuffled orders.
    """
    slack = 1e-9 * float(np.abs(values).max())
    return float((values >= values[0] - slack).mean())


def classes_of(asked: BoolArray) -> list[IntArray]:
    """Return classes of at least two agents; agents of one class were asked the same kinds of questions.

    Args:
        asked: whether each agent was asked each kind, (N, kinds).
    """
    classes: dict[tuple[bool, ...], list[int]] = {}
    for agent, kinds in enumerate(map(tuple, asked.tolist())):
        classes.setdefault(kinds, []).append(agent)
    return [np.array(members) for kinds, members in classes.items() if any(kinds) and len(members) > 1]


@lru_cache(maxsize=8)
def _orders(size: int) -> IntArray:
    return np.array(list(permutations(range(size))), dtype=np.int64)


@lru_cache(maxsize=8)
def _cached_blocks(number: int, size: int) -> tuple[IntArray, ...]:
    return tuple(_blocks(number, size))


def _blocks(number: int, size: int) -> Iterator[IntArray]:
    """Yield the actual order, then random orders, in blocks that fit into memory."""
    yield np.arange(size)[None]
    stream, rows = seeding.stream(number, "shuffled agents"), max(1, _AT_ONCE // size)
    for start in range(0, DRAWS, rows):
        yield stream.permuted(np.tile(np.arange(size), (min(rows, DRAWS - start), 1)), axis=1)
