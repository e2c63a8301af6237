"""How the minimal naming game grows with its population, played by whoever draws evenly among the names it knows."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from foundry import seeding
from foundry.worlds.base import Answer
from foundry.worlds.rounds.naming import CONSENSUS, SPEAKER, Meeting, NamingGame

PEAKS = {50: 160, 100: 60, 200: 30, 400: 16, 800: 10}
CONSENSUSES = {50: 60, 100: 30, 200: 16, 400: 8, 800: 6}
"""Runs that are played by number of agents: fewer of those that last longer, and vary less."""


def peak_exponent() -> tuple[float, float]:
    """Return the exponent of the time at which most names are known, by number of agents, and its standard error.

    Source: Baronchelli et al. 2006 (arXiv physics/0509075), who find 1.5.
    """
    return _exponent([(agents, peak(agents, seed)) for agents, runs in PEAKS.items() for seed in range(runs)])


def consensus_exponent() -> tuple[float, float]:
    """Return the exponent of the time to consensus, by number of agents, and its standard error.

    It is that of these sizes alone: it comes to the 1.5 of the source only in populations of many thousands.
    """
    return _exponent([(agents, consensus(agents, one)) for agents, runs in CONSENSUSES.items() for one in range(runs)])


def _exponent(points: Sequence[tuple[int, int]]) -> tuple[float, float]:
    """Return the slope of log(interactions) over log(agents) by least squares, and its standard error.

    The error is that of White 1980, which holds where runs of different sizes vary differently.
    """
    x, y = np.log(np.array(points, dtype=np.float64)).T
    from_mean = x - x.mean()
    squares = float((from_mean**2).sum())
    slope = float((from_mean * y).sum()) / squares
    left = y - y.mean() - slope * from_mean
    return slope, math.sqrt(float((from_mean**2 * left**2).sum())) / squares


def peak(agents: int, seed: int) -> int:
    """Return after how many interactions the agents know most names, counted with every agent that knows them.

    The run goes on for twice as long as that is expected to take.
    """
    known: list[set[str]] = [set() for _ in range(agents)]
    total, most, when = 0, 0, 0
    for met in sorted(_meetings(agents, seed, rounds=math.ceil(2.4 * math.sqrt(agents))), key=lambda one: one.number):
        speaker, hearer, name = known[met.first], known[met.second], str(met.first_name)
        before = len(speaker) + len(hearer)
        speaker.add(name)
        if met.equal:
            known[met.first], known[met.second] = {name}, {name}
        else:
            hearer.add(name)
        total += len(known[met.first]) + len(known[met.second]) - before
        if total > most:
            most, when = total, met.number
    return when


def consensus(agents: int, seed: int) -> int:
    """Return after how many interactions a round comes in which 95 % of them succeed."""
    return max(one.number for one in _meetings(agents, seed, rounds=math.ceil(40 * math.sqrt(agents)), until=CONSENSUS))


def _meetings(agents: int, seed: int, *, rounds: int, until: str | None = None) -> Iterator[Meeting]:
    """Yield the interactions of a run."""
    game = NamingGame(
        name="naming",
        agents=agents,
        steps=rounds,
        names=None,
        protocol=SPEAKER,
        memory=0,
        equal=1,
        different=0,
        established=None,
        committed=0,
        committed_name=None,
        until=until,
    )
    world, rng = game.start(seed), seeding.stream(seed, "speakers")
    while not world.finished:
        replies = [one.options[int(rng.integers(len(one.options)))] for one in world.pending()]
        yield from (one for one in world.advance([Answer(one) for one in replies]) if isinstance(one, Meeting))
