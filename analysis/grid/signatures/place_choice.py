"""Place choice: in which places agents spend their time, and whether places get more agents than their capacity.

State 0, the start, does not count, because the seed draws the start. Agents are told the capacity of each place, but a
place admits more agents than its capacity.
"""

import math

import numpy as np

from analysis.arrays import BoolArray, IntArray
from analysis.formulas import jensen_shannon, mean, normalised_entropy, ratio, weighted_mean, weighted_variance
from analysis.grid.grid_run import OUTSIDE, GridRun
from analysis.measure import Measure, share

NAME = "place_choice"

MEASURES = {
    "share_*": share("Time in * (share)", says="spends {more|less} time in *"),
    "share_outside": share("Time outside all places (share)"),
    "first_choice_*": share("* entered first (share of entering agents)"),
    "switch_rate": share("Changes of place (per decision spent in places)"),
    "overcrowding_since_entry": share("Steps over capacity, from the first entry on (share, mean of places)"),
    "overcrowding": share("Steps over capacity (share, mean of places)", says="crowds places {more|less}"),
    "overcrowding_*": share("Steps over capacity in * (share)"),
    "utilisation_since_entry": share("Used capacity, from the first entry on (share, mean of places)"),
    "utilisation": share("Used capacity (share, mean of places)"),
    "utilisation_*": share("Used capacity of * (share)"),
    "volatility_since_entry": Measure("Volatility of attendance, from the first entry on (variance / N)", low=0),
    "volatility": Measure("Volatility of attendance (variance / N, mean of places)", low=0),
    "volatility_*": Measure("Volatility of attendance of * (variance / N)", low=0),
    "entropy": share("Entropy over places and outside (of its maximum)"),
    "entropy_places": share("Entropy over places only (of its maximum)"),
    "capacity_divergence": share("Divergence of the time in places from their capacities"),
}

HEADLINE = ("share_*", "overcrowding", "utilisation")


def measure(run: GridRun) -> dict[str, float]:
    """Return which places agents choose in a run; x_k(t) agents are in place k at state t, and C_k is its capacity.

    An agent-state is one agent in one state; it counts if a counted decision of the agent led to the state. A state
    weighs by the number of such decisions.

    - share_<place>: share of the agent-states that are in place k, which is the mean of x_k / N; 0..1. share_outside:
      share of the agent-states that are in no place.
    - first_choice_<place>: agents that enter place k first / agents that enter any place; 0..1. An agent enters a place
      if it is there at state t but not at t - 1. NaN if nobody enters.
    - switch_rate: entries into a place other than the agent's previous one / agent-states in places; 0..1. NaN if
      nobody is in a place.
    - overcrowding_<place>: share of states with x_k > C_k (strictly); 0..1.
    - utilisation_<place>: mean of min(x_k, C_k) / C_k; 0..1. 0 if nobody enters. NaN without capacity.
    - volatility_<place>: Var_t(x_k) / N, ddof 0; 0..N/4. Independent coin flips at p give p(1 - p).
      Source: minority game, Challet and Zhang 1997.
    - overcrowding, utilisation, volatility: means over the places. NaN without places.
    - overcrowding_since_entry, utilisation_since_entry, volatility_since_entry: these means over the places that anyone
      uses, where each place counts only from the first state 1..T in which someone is there. NaN if no place is used.
    - entropy: entropy of the agent-states over the places and outside / log of their number; 0..1. NaN without places.
      entropy is low for agents that stay at their starts, since their states cover few places.
    - entropy_places: entropy over the places only; NaN if nobody is in a place, or with fewer than two places.
    - capacity_divergence: Jensen-Shannon divergence (base 2) between the agent-states in the places and the places'
      capacities; 0 (in proportion)..1. NaN where entropy_places is NaN. Source: Lin 1991.

    Denominators: n_states (with weight), n_agent_states, n_in_place (agent-states), n_entering (agents).
    """
    places = range(len(run.world.places))
    inside = np.array([(run.place[1:] == index) & run.counted for index in places]).reshape(-1, run.choice.size)
    totals, every = inside.sum(axis=1), int(run.counted.sum())
    outside = every - int(totals.sum())
    names = [place.name for place in run.world.places]
    entered = _entered(run)
    first = _first_entered(run.place, entered)
    entering = int((first != OUTSIDE).sum())
    return {
        **{f"share_{name}": ratio(int(total), every) for name, total in zip(names, totals, strict=True)},
        "share_outside": ratio(outside, every),
        **{f"first_choice_{name}": ratio(int((first == k).sum()), entering) for k, name in enumerate(names)},
        "switch_rate": ratio(count_switches(run.place, entered), int(totals.sum())),
        **_crowding(run),
        "entropy": normalised_entropy([*totals, outside]) if every else math.nan,
        "entropy_places": normalised_entropy(totals),
        "capacity_divergence": _capacity_divergence(run, totals),
        "n_states": float(run.counted.any(axis=1).sum()),
        "n_agent_states": float(every),
        "n_in_place": float(totals.sum()),
        "n_entering": float(entering),
    }


def _capacity_divergence(run: GridRun, totals: IntArray) -> float:
    capacities = [place.capacity for place in run.world.places]
    return jensen_shannon(totals, capacities) if len(capacities) > 1 else math.nan


def _crowding(run: GridRun) -> dict[str, float]:
    weights, attendance = run.counted.sum(axis=1), count_attendance(run)
    measures: dict[str, float] = {}
    since: dict[str, list[float]] = {"overcrowding": [], "utilisation": [], "volatility": []}
    for place, present in zip(run.world.places, attendance.T, strict=True):
        for name, value in attendance_measures(present, place.capacity, run.agents, weights).items():
            measures[f"{name}_{place.name}"] = value
        used = np.flatnonzero(present)
        if len(used):
            later = attendance_measures(present[used[0] :], place.capacity, run.agents, weights[used[0] :])
            for name, value in later.items():
                since[name].append(value)
    whole = {
        name: mean(measures[f"{name}_{place.name}"] for place in run.world.places)
        for name in ("overcrowding", "utilisation", "volatility")
    }
    return {**measures, **whole, **{f"{name}_since_entry": mean(values) for name, values in since.items()}}


def attendance_measures(present: IntArray, capacity: int, agents: int, weights: IntArray) -> dict[str, float]:
    """Return overcrowding, utilisation and volatility of a place; `present` is the number of agents there, (T,)."""
    used = np.minimum(present, capacity) / capacity if capacity else np.full(len(present), math.nan)
    return {
        "overcrowding": weighted_mean(present > capacity, weights),
        "utilisation": weighted_mean(used, weights),
        "volatility": weighted_variance(present, weights) / agents,
    }


def count_attendance(run: GridRun) -> IntArray:
    """Return the number of agents in each place at states 1..T, (T, places)."""
    counts = [(run.place[1:] == index).sum(axis=1) for index in range(len(run.world.places))]
    return np.array(counts, dtype=np.int64).reshape(-1, run.steps).T


def _entered(run: GridRun) -> BoolArray:
    """Return whether each agent entered a place by its counted decision at steps 1..T, (T, N)."""
    place = run.place
    return np.asarray((place[1:] != OUTSIDE) & (place[1:] != place[:-1]) & run.counted)


def _first_entered(place: IntArray, entered: BoolArray) -> IntArray:
    """Return the place that each agent enters first, or OUTSIDE, (N,); place is (T + 1, N), entered (T, N)."""
    agents = np.arange(place.shape[1])
    return np.where(entered.any(axis=0), place[1:][entered.argmax(axis=0), agents], OUTSIDE)


def count_switches(place: IntArray, entered: BoolArray) -> int:
    """Return how often agents enter a place other than their previous one; place is (T + 1, N), entered (T, N)."""
    states = np.arange(len(place))[:, None]
    last = np.maximum.accumulate(np.where(place != OUTSIDE, states, -1), axis=0)[:-1]
    before = np.where(last >= 0, np.take_along_axis(place, np.maximum(last, 0), axis=0), place[1:])
    return int((entered & (before != place[1:])).sum())
