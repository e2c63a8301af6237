"""Public goods: how much agents give, whether they follow what others gave, and how much they pay to punish."""

import math

import numpy as np

from analysis.arrays import BoolArray, FloatArray
from analysis.formulas import mean, ratio
from analysis.measure import Measure, Null, share
from analysis.rounds.rounds_run import RoundsRun

NAME = "public_goods"
GIVE, PUNISH = "contribution", "punishment"

MEASURES = {
    "score": Measure("Kept tokens (%)", 0, 100, says="keeps {more|fewer} tokens"),
    "contribution": Measure("Tokens given per round (mean)", low=0),
    "trend": Measure(
        "Change of the given share per round", -1, 1, Null(0, "gives without regard to the round and the others")
    ),
    "conditional": Measure("Tokens given per token that the others gave before (slope)"),
    "free_riders": share("Agents that never give (share)"),
    "nothing": share("Decisions to give nothing (share)"),
    "efficiency": Measure("Gain, relative to the greatest common gain", high=1),
    "punishing": share("Decisions to punish (share)"),
    "spent": Measure("Tokens spent on punishment per round (mean)", low=0),
    "antisocial": share("Punishments of agents that gave at least as much as the punisher (share)"),
}

_FEWEST_ROUNDS = 10
"""Minimum number of rounds for `conditional`: in shorter runs, chance alone often gives a large slope."""

HEADLINE = ("score", "trend", "conditional", "free_riders", "efficiency", "punishing", "antisocial")


def applies(run: RoundsRun) -> bool:
    """Return whether the world is a public goods game with a multiplied pot."""
    return "multiplier" in run.world and GIVE in run.declared.actions and "tokens" in run.columns


def measure(run: RoundsRun) -> dict[str, float]:
    """Return how much agents give; in each counted decision an agent contributes c of the h tokens that it has.

    - score: 100 (1 - mean of c / h), for agents with tokens; it rewards free riding. Source: GAMABench.
    - contribution: mean of c, tokens.
    - trend: slope of the mean of c / h over the rounds (least squares); 0 for constant giving. NaN below two rounds.
    - conditional: slope of an agent's c on the others' mean contribution the round before, pooled over agents (least
      squares). A straight line over the rounds, fitted for each agent, is first subtracted from both. An agent that
      gives along a straight line has 0. Still, a value other than 0 does not prove that agents follow each other: they
      may independently follow one common curve. Only the design of a study can tell the two apart. NaN below ten
      rounds, because random giving then looks like following: .5 at five rounds, .2 at eight, below .05 from ten on.
      The spread between runs is .3 at ten rounds and .2 at twenty. Source: Fischbacher, Gächter and Fehr 2001.
    - free_riders: agents whose contributions are all 0 / agents. nothing: contributions of 0 / contributions.
    - efficiency: (mean payoff - initial tokens) / its value if all give everything. 1 if all do, 0 if nobody gives,
      below 0 if punishment costs more than giving yields. NaN if tokens are carried over.

    With punishment:

    - punishing: decisions to punish / decisions on punishment. spent: cost of punishing per decision, tokens.
    - antisocial: punishments of agents that gave at least as much as their punisher / punishments. NaN without
      punishments. Source: Herrmann, Thoeni and Gächter 2008.

    NaN without contributions. Denominators: n_contributions, n_rounds, n_agents (with a contribution); n_punishments.
    """
    counts, given, had = run.counts(GIVE), run.numbers(GIVE), run.column(GIVE, "tokens")
    some = counts & (had > 0)
    shares = np.divide(given, had, out=np.full(given.shape, np.nan), where=some)
    acted = counts.any(axis=0)
    riders = acted & (np.where(counts, given, 0) == 0).all(axis=0)
    measures = {
        "score": 100 * (1 - mean(shares[some])),
        "contribution": mean(given[counts]),
        "trend": _trend(shares),
        "conditional": _conditional(given, counts),
        "free_riders": ratio(float(riders.sum()), float(acted.sum())),
        "nothing": mean(given[counts] == 0),
        "efficiency": _efficiency(run, counts),
        "n_contributions": float(counts.sum()),
        "n_rounds": float(counts.any(axis=1).sum()),
        "n_agents": float(acted.sum()),
    }
    return measures | (_punishment(run, given) if PUNISH in run.declared.actions else {})


def _trend(shares: FloatArray) -> float:
    """Return the slope of a line fitted to each round's mean share; shares are (T, N)."""
    known = ~np.isnan(shares)
    rounds = np.flatnonzero(known.any(axis=1))
    if len(rounds) < 2:
        return math.nan
    values = np.array([mean(shares[round_record][known[round_record]]) for round_record in rounds])
    return float(np.polynomial.polynomial.polyfit(rounds, values, 1)[1])


def _conditional(given: FloatArray, counts: BoolArray) -> float:
    """Return how strongly an agent's contribution follows the mean contribution of the others in the round before.

    It is a slope, computed after the linear trend of each agent over the rounds is removed.
    """
    if len(given) < _FEWEST_ROUNDS or given.shape[1] < 2:
        return math.nan
    known = np.where(np.isnan(given), 0.0, given)
    others = (known.sum(axis=1, keepdims=True) - known)[:-1] / (given.shape[1] - 1)
    products = squares = 0.0
    for agent in range(given.shape[1]):
        rounds = np.flatnonzero(counts[1:, agent])
        if len(rounds) > 2:
            line = np.linalg.qr(np.column_stack([np.ones(len(rounds)), rounds - rounds.mean()]))[0]
            seen = others[rounds, agent] - line @ (line.T @ others[rounds, agent])
            products += float(seen @ known[rounds + 1, agent])
            squares += float(seen @ seen)
    return ratio(products, squares) if squares > 1e-9 else math.nan


def _efficiency(run: RoundsRun, counts: BoolArray) -> float:
    payoffs = run.placed(GIVE, run.utility, fill=np.nan)[counts]
    tokens, multiplier = float(run.world["tokens"]), float(run.world["multiplier"])
    return ratio(mean(payoffs) - tokens, tokens * (multiplier - 1)) if run.world["reset"] else math.nan


def _punishment(run: RoundsRun, given: FloatArray) -> dict[str, float]:
    """Return the measures of punishment. In a decision to punish, label 0 means nobody, and label 1 means agent 0."""
    counts, whom = run.counts(PUNISH), run.choices(PUNISH) - 1
    punishing = counts & (whom >= 0)
    rounds, agents = np.nonzero(punishing)
    is_antisocial = given[rounds, whom[rounds, agents]] >= given[rounds, agents]
    rate = ratio(float(punishing.sum()), float(counts.sum()))
    return {
        "punishing": rate,
        "spent": rate * float(run.world["cost"]),
        "antisocial": mean(is_antisocial),
        "n_punishments": float(punishing.sum()),
    }
