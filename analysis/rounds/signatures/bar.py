"""Bar: how close the attendance comes to the capacity of a bar, and whether agents take turns."""

import math
from functools import lru_cache

import numpy as np

from analysis.arrays import FloatArray
from analysis.formulas import mean, ratio
from analysis.measure import HIGH, Measure, Null, share
from analysis.rounds.rounds_run import RoundsRun

NAME = "bar"
KIND, GO = "evening", "go"

MEASURES = {
    "score": Measure(
        "Nearness of the attendance to the capacity",
        0,
        100,
        better=HIGH,
        says="fills the bar {nearer to|further from} its capacity",
    ),
    "score_of_coins": Measure("Nearness of coin flips to the capacity", 0, 100),
    "score_over_coins": Measure(
        "Nearness to the capacity, beyond coin flips", -100, 100, Null(0, "goes or stays by a coin flip"), better=HIGH
    ),
    "share": share("Mean share that goes"),
    "crowded": share("Crowded evenings (share)"),
    "volatility": Measure("Variance of the attendance per agent", low=0),
    "volatility_ratio": Measure(
        "Variance of the attendance, relative to independent agents",
        low=0,
        null=Null(1, "goes as often as it likes without regard to others"),
    ),
    "alternation": Measure(
        "Evenings that turn crowded or empty, beyond chance (share)",
        -1,
        1,
        Null(0, "goes without regard to earlier evenings"),
    ),
    "constant": share("Agents that never change (share)"),
}

HEADLINE = ("score", "score_over_coins", "share", "volatility_ratio", "alternation", "constant")


def applies(run: RoundsRun) -> bool:
    """Return whether the world is a bar with a capacity."""
    return "capacity" in run.world and KIND in run.declared.actions


def measure(run: RoundsRun) -> dict[str, float]:
    """Return how a crowd uses a bar, over the evenings with counted decisions.

    c is the capacity, a share of all agents. a_t is the share of the n_t counted decisions of evening t that go.

    - score: 100 (1 - mean of |a_t - c| / max(c, 1 - c)); 100 when the bar is always just full. Source: GAMABench.
    - score_of_coins: exact mean score of n_t coin flips (binomial distribution). score_over_coins: score -
      score_of_coins; 0 for coin flips, above 0 if all agents go with the probability of the mixed equilibrium.
    - share: mean of a_t. crowded: evenings with a_t > c / evenings.
    - volatility: mean over the evenings of (sum of the agents' deviations)^2 / agents. An agent's deviation is 1 if it
      goes, 0 if it stays, minus its own mean. If all decisions count, volatility is the variance of the attendance / N.
      Independent agents that go with probability p give p (1 - p).
    - volatility_ratio: sum over the evenings of (sum of the deviations)^2 / sum of the squares of all deviations. 1 for
      independent agents, whatever their habits; below 1 if agents avoid each other, above 1 if they herd. NaN if nobody
      ever changes. Source: Challet and Zhang 1997.
    - alternation: pairs of successive evenings with exactly one crowded evening / pairs, minus its mean over all orders
      of the evenings, 2 n_c (n - n_c) / (n (n - 1)). n is the number of evenings, n_c the number of crowded evenings.
      NaN below two evenings.
    - constant: agents that always go or always stay / agents with a counted decision.

    NaN without evenings. Denominators: n_evenings, n_agents (with a counted decision).
    """
    counts, goes = run.counts(KIND), run.choices(KIND) == run.declared.actions[KIND].labels.index(GO)
    held = counts.any(axis=1)
    counts, goes = counts[held], (goes & counts)[held]
    number, went = counts.sum(axis=1), goes.sum(axis=1)
    capacity = float(run.world["capacity"])
    if not held.any():
        return dict.fromkeys(MEASURES, np.nan) | {"n_evenings": 0.0, "n_agents": 0.0}
    attendance, crowded = went / number, went / number > capacity
    nearness = _score(np.abs(attendance - capacity), capacity)
    of_coins = _score(np.array([coins_off(int(tonight), capacity) for tonight in number]), capacity)
    acted = counts.sum(axis=0)
    own = goes.sum(axis=0) / np.maximum(acted, 1)
    deviations = np.where(counts, goes - own, 0.0)
    squares = float((deviations.sum(axis=1) ** 2).sum())
    return {
        "score": nearness,
        "score_of_coins": of_coins,
        "score_over_coins": nearness - of_coins,
        "share": mean(attendance),
        "crowded": mean(crowded),
        "volatility": squares / len(attendance) / run.agents,
        "volatility_ratio": ratio(squares, float((deviations**2).sum())),
        "alternation": _alternation(crowded),
        "constant": ratio(float(np.isin(own[acted > 0], (0, 1)).sum()), float((acted > 0).sum())),
        "n_evenings": float(len(attendance)),
        "n_agents": float((acted > 0).sum()),
    }


@lru_cache(maxsize=1024)
def coins_off(agents: int, capacity: float) -> float:
    """Return the mean distance of the attendance from the capacity if each agent flips a coin, as a share of agents."""
    heads = np.arange(agents + 1)
    chances = np.array([math.comb(agents, int(count)) / 2**agents for count in heads])
    return float(chances @ np.abs(heads / agents - capacity))


def _score(distances: FloatArray, capacity: float) -> float:
    return 100 * (1 - mean(distances) / max(capacity, 1 - capacity))


def _alternation(crowded: FloatArray) -> float:
    """Return the share of neighbouring evenings that differ in `crowded`, (T,), minus its mean over all orders."""
    number, full = len(crowded), float(crowded.sum())
    turns = float((crowded[1:] != crowded[:-1]).sum())
    return ratio(turns, number - 1) - ratio(2 * full * (number - full), number * (number - 1.0))
