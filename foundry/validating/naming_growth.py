"""How the minimal naming game grows with its population, played by whoever draws evenly among the names it knows."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from foundry import seeding
from foundry.worlds.base import Answer
from foundry.worlds.rounds.naming import SPEAKER, Meeting, NamingGame

RUNS = {50: 24, 100: 16, 200: 10, 400: 6, 800: 3}
"""Runs that are played by number of agents: fewer of those that last longer."""


def peak_exponent() -> tuple[float, float]:
    """Return the exponent of the time at which most names are known, by number of agents, and its standard error.

    It is the slope of log(interactions until the peak) over log(agents), by least squares over all runs.
    Source: Baronchelli et al. 2006 (arXiv physics/0509075), who find 1.5.
    """
    points = [(agents, peak(agents, seed)) for agents, runs in RUNS.items() for seed in range(runs)]
    x, y = np.log(np.array(points, dtype=np.float64)).T
    from_mean = x - x.mean()
    slope = float((from_mean * y).sum() / (from_mean**2).sum())
    left = y - y.mean() - slope * from_mean
    return slope, math.sqrt(float((left**2).sum()) / (len(x) - 2) / float((from_mean**2).sum()))


def peak(agents: int, seed: int) -> int:
    """Return after how many interactions the agents know most names, counted with every agent that knows them."""
    known: list[set[str]] = [set() for _ in range(agents)]
    total, most, when = 0, 0, 0
    for met in sorted(_meetings(agents, seed), key=lambda one: one.number):
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


def _meetings(agents: int, seed: int) -> Iterator[Meeting]:
    """Yield the interactions of a run that goes on for twice as long as the peak is expected to take."""
    game = NamingGame(
        name="naming",
        agents=agents,
        steps=math.ceil(2.4 * math.sqrt(agents)),
        names=None,
        protocol=SPEAKER,
        memory=0,
        equal=1,
        different=0,
        established=None,
        committed=0,
        committed_name=None,
        until=None,
    )
    world, rng = game.start(seed), seeding.stream(seed, "speakers")
    while not world.finished:
        replies = [one.options[int(rng.integers(len(one.options)))] for one in world.pending()]
        yield from (one for one in world.advance([Answer(one) for one in replies]) if isinstance(one, Meeting))
