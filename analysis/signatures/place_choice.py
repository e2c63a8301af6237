"""Place choice: where agents spend their time, and whether they crowd.

Counted over states 1..T; the start, state 0, is drawn by the world. Capacities are numbers that agents are
told: nothing enforces them.
"""

from __future__ import annotations

import math

import numpy as np

from analysis.described import Measure, share
from analysis.formulas import mean, normalised_entropy, ratio
from analysis.run import OUTSIDE, GridRun, IntArray

NAME = "place_choice"

MEASURES = {
    "share_*": share("Time in * (share)"),
    "share_outside": share("Time outside all places (share)"),
    "first_choice_*": share("* entered first (share of entering agents)"),
    "overcrowding": share("Steps over capacity (share, mean of places)"),
    "overcrowding_*": share("Steps over capacity in * (share)"),
    "utilisation": share("Used capacity (share, mean of places)"),
    "utilisation_*": share("Used capacity of * (share)"),
    "volatility": Measure("Volatility of attendance (variance / N, mean of places)", low=0),
    "volatility_*": Measure("Volatility of attendance of * (variance / N)", low=0),
    "entropy": share("Entropy over places and outside (of its maximum)"),
    "entropy_places": share("Entropy over places alone (of its maximum)"),
}

HEADLINE = ("share_*", "overcrowding", "utilisation", "entropy")


def measure(run: GridRun) -> dict[str, float]:
    """Return the place choice of a run; x_k(t) is the number of agents in place k at state t, C_k its capacity.

    - share_<place>: mean of x_k / N; 0..1. share_outside: the same for agents in no place.
    - first_choice_<place>: agents whose first entered place is k / agents that enter any; 0..1. Entering is
      being in a place at state t and not in it at t - 1. NaN when nobody enters.
    - overcrowding_<place>: share of states with x_k > C_k (strictly); 0..1.
    - utilisation_<place>: mean of min(x_k, C_k) / C_k; 0..1.
    - volatility_<place>: Var_t(x_k) / N, ddof 0; 0..N/4. Independent coin flips at p give p(1 - p).
      Source: minority game, Challet and Zhang 1997.
    - overcrowding, utilisation, volatility: means over the places. NaN without places.
    - entropy: entropy of the agent-states over the places and outside / log of their number; 0..1. NaN
      without places.
    - entropy_places: the same over the places alone; NaN when nobody is in one, or with fewer than two.

    Denominators: n_states, n_agent_states, n_in_place (agent-states), n_entering (agents).
    """
    attendance = count_attendance(run)
    outside = run.decisions - int(attendance.sum())
    totals = attendance.sum(axis=0)
    names = [place.name for place in run.world.places]
    first = _first_entered(run.place)
    entering = int((first != OUTSIDE).sum())
    found = {f"share_{name}": ratio(total, run.decisions) for name, total in zip(names, totals, strict=True)}
    found["share_outside"] = ratio(outside, run.decisions)
    for index, name in enumerate(names):
        found[f"first_choice_{name}"] = ratio(int((first == index).sum()), entering)
    return {
        **{name: float(value) for name, value in found.items()},
        **_crowding(run, attendance),
        "entropy": normalised_entropy([*totals, outside]),
        "entropy_places": normalised_entropy(totals),
        "n_states": float(run.steps),
        "n_agent_states": float(run.decisions),
        "n_in_place": float(totals.sum()),
        "n_entering": float(entering),
    }


def _crowding(run: GridRun, attendance: IntArray) -> dict[str, float]:
    found: dict[str, float] = {}
    for place, present in zip(run.world.places, attendance.T, strict=True):
        found[f"overcrowding_{place.name}"] = overcrowding(present, place.capacity)
        found[f"utilisation_{place.name}"] = utilisation(present, place.capacity)
        found[f"volatility_{place.name}"] = volatility(present, run.agents)
    for name in ("overcrowding", "utilisation", "volatility"):
        found[name] = mean(value for key, value in found.items() if key.startswith(f"{name}_"))
    return found


def count_attendance(run: GridRun) -> IntArray:
    """Return the number of agents in each place at states 1..T, (T, places)."""
    counts = [(run.place[1:] == index).sum(axis=1) for index in range(len(run.world.places))]
    return np.array(counts, dtype=np.int64).reshape(-1, run.steps).T


def overcrowding(attendance: IntArray, capacity: int) -> float:
    """Return the share of states with more agents than the capacity; attendance (T,)."""
    return mean(attendance > capacity)


def utilisation(attendance: IntArray, capacity: int) -> float:
    """Return the mean used share of the capacity; attendance (T,)."""
    return mean(np.minimum(attendance, capacity) / capacity) if capacity else math.nan


def volatility(attendance: IntArray, agents: int) -> float:
    """Return the variance of the attendance over the number of agents; attendance (T,)."""
    return float(np.var(attendance)) / agents


def _first_entered(place: IntArray) -> IntArray:
    """Return the place each agent enters first, or OUTSIDE; place (T + 1, N), result (N,)."""
    entered = (place[1:] != OUTSIDE) & (place[1:] != place[:-1])
    first = entered.argmax(axis=0)
    agents = np.arange(place.shape[1])
    return np.where(entered.any(axis=0), place[1:][first, agents], OUTSIDE)
