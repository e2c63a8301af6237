"""Shuffles of agents: all orders of a few, else random ones, the same in every process and on every machine."""

from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from itertools import permutations

import numpy as np

from analysis.arrays import BoolArray, FloatArray, IntArray
from foundry import seeding

DRAWS = 999
"""Random shuffles, besides the order as it is."""

FEW = 6
"""Agents of which all orders are taken, 720 at most."""

_AT_ONCE = 1_000_000
"""Numbers of shuffled agents that are held at a time."""


def over_shuffles(statistic: Callable[[IntArray], FloatArray], classes: int, number: int, size: int) -> FloatArray:
    """Return a statistic of the agents of a class as they are, then of their shuffles, (R,).

    Args:
        statistic: takes orders of the agents (r, size), returns its values (r,).
        classes: into how many classes the agents of the run fall; of a single small one all orders are taken.
        number: of this class.
        size: number of its agents.
    """
    if classes == 1 and size <= FEW:
        return statistic(_orders(size))
    return np.concatenate([statistic(rows) for rows in _random(number, size)])


def p_value(values: FloatArray) -> float:
    """Return the share of values (R,) that are as great as the first, or greater; rounding apart."""
    slack = 1e-9 * float(np.abs(values).max())
    return float((values >= values[0] - slack).mean())


def classes_of(asked: BoolArray) -> list[IntArray]:
    """Return the agents in classes of two or more that were asked the same kinds of questions.

    Args:
        asked: whether it was asked, by agent and kind, (N, kinds).
    """
    found: dict[tuple[bool, ...], list[int]] = {}
    for agent, kinds in enumerate(map(tuple, asked.tolist())):
        found.setdefault(kinds, []).append(agent)
    return [np.array(members) for kinds, members in found.items() if any(kinds) and len(members) > 1]


@lru_cache(maxsize=8)
def _orders(size: int) -> IntArray:
    return np.array(list(permutations(range(size))), dtype=np.int64)


def _random(number: int, size: int) -> Iterable[IntArray]:
    return _kept(number, size) if size * DRAWS <= _AT_ONCE else _blocks(number, size)


@lru_cache(maxsize=8)
def _kept(number: int, size: int) -> tuple[IntArray, ...]:
    return tuple(_blocks(number, size))


def _blocks(number: int, size: int) -> Iterator[IntArray]:
    """Yield the order as it is, then the random ones, so many at once that the memory holds them."""
    yield np.arange(size)[None]
    stream, rows = seeding.stream(number, "shuffled agents"), max(1, _AT_ONCE // size)
    for start in range(0, DRAWS, rows):
        yield stream.permuted(np.tile(np.arange(size), (min(rows, DRAWS - start), 1)), axis=1)
