"""Evacuation: how many agents get out, when, and by which exits; times are compared with the shortest possible."""

import math
from functools import lru_cache

import numpy as np

from analysis.arrays import FloatArray, IntArray
from analysis.formulas import mean, ratio
from analysis.grid.distances import steps_to
from analysis.grid.grid_run import NO_EXIT, GridRun, GridSettings
from analysis.grid.signatures.warning import deliveries_of, find_labels
from analysis.measure import HIGH, LOW, Measure, share
from foundry.leaving import FAR, soonest_departures

NO_WAY = -1


@lru_cache(maxsize=16)
def exit_steps(world: GridSettings) -> IntArray:
    """Return the fewest steps from every cell to each of E exits, (E, W, W), indexed by exit, x and y.

    The number is NO_WAY if no path leads to the exit. Paths lead around walls and around other exits.
    """
    half = world.half_size
    fields = []
    for own in world.exits:
        free, goal = world.free(), np.zeros((world.width, world.width), dtype=np.bool_)
        for exit_zone in world.exits:
            for x, y in exit_zone.cells:
                free[x + half, y + half] = exit_zone is own
        for x, y in own.cells:
            goal[x + half, y + half] = True
        fields.append(steps_to(goal, free))
    return np.array(fields, dtype=np.int64).reshape(-1, world.width, world.width)


def start_distances(run: GridRun) -> IntArray:
    """Return the fewest steps from each agent's start to each exit, (E, N); NO_WAY if no path leads there."""
    half = run.world.half_size
    return exit_steps(run.world)[:, run.x[0] + half, run.y[0] + half]


def soonest(run: GridRun) -> FloatArray:
    """Return, for n = 1..N, the earliest step after which n of the initial agents can be out, (N,); inf if never.

    The result is a lower bound for every policy. In each step an exit lets out at most its capacity, and nobody arrives
    before the shortest path allows. Crowds, fires and ignorance of the way can only delay agents.
    """
    distances = start_distances(run)[:, : run.world.agents].T
    far = np.where(distances == NO_WAY, FAR, distances).tolist()
    departures = soonest_departures(far, [exit_zone.capacity for exit_zone in run.world.exits])
    return np.sort([np.inf if departure is None else float(departure.step) for departure in departures])


NAME = "evacuation"

READABLE_TOO = False

MEASURES = {
    "out": share("Agents that got out (share)", better=HIGH, says="gets {more|fewer} agents out"),
    "lost": share("Agents that died (share)", better=LOW),
    "time_50": Measure("Step by which half are out", low=1, better=LOW),
    "time_90": Measure("Step by which nine in ten are out", low=1, better=LOW),
    "lower_bound": Measure("First step by which nine in ten can be out", low=1),
    "lower_bound_50": Measure("First step by which half can be out", low=1),
    "over_bound": Measure("Time until nine in ten are out / shortest possible time", low=1, better=LOW),
    "over_bound_50": Measure("Time until half are out / shortest possible time", low=1, better=LOW),
    "share_*": share("Left by * (share of those out)"),
    "nearest": share("Left by the nearest exit (share)"),
    "with_leaders": share("Left by the exit that most leaders used (share of the others)"),
    "least_crowded": share("Left by a least crowded exit (share)"),
    "herding": Measure("Pairs that use the same exit, minus pairs with the same nearest exit (share)", -1, 1),
    "path_efficiency": share("Shortest path / steps taken, waits included"),
    "path_efficiency_moving": share("Shortest path / moves made"),
    "warned": share("Heard a warning before leaving (share of those out)"),
    "warnings_heard": Measure("Warnings heard before leaving (mean of those out)", low=0),
}

HEADLINE = ("out", "time_50", "over_bound", "nearest", "path_efficiency")

AT_IT = 2
"""An agent is near an exit if it is at most this number of columns and rows away from a cell of the exit."""


def applies(run: GridRun) -> bool:
    """Return whether the world has exits."""
    return bool(run.world.exits)


def measure(run: GridRun) -> dict[str, float]:
    """Return the evacuation of a run in a world with exits; N is the number of agents at the start.

    - out: agents that left by an exit / N; 0..1. lost: agents that died / N; 0..1.
    - time_50, time_90: first step after which ceil(N/2), ceil(9N/10) agents are out; NaN (censored) if that never
      happens.
    - lower_bound, lower_bound_50: the first step by which as many agents as for time_90, time_50 can be out, if all
      take the shortest ways round walls and an exit lets out at most its capacity per step. NaN if too few agents have
      a way out.
    - over_bound, over_bound_50: time_90 / lower_bound, time_50 / lower_bound_50; from 1. NaN if too few agents get out,
      so show `out` with them.

    Over agents that got out; NaN without any:

    - share_<exit>: agents that left by this exit / out; 0..1.
    - nearest: agents that left by the exit nearest to their start, ties included / out; 0..1.
    - with_leaders: among the agents other than leaders, those that left by the exit that most leaders used (the first,
      if tied) / those that got out; 0..1. NaN if no leader got out.
    - least_crowded: agents that left by an exit with the fewest agents near it / out; 0..1. An agent is near an exit if
      its cell is within AT_IT columns and rows of the exit. The agents near each exit are counted once, halfway through
      the steps that the agent took to leave, at the exits that it can reach.
    - herding: share of the pairs of agents that left by the same exit, minus this share if each had taken its nearest
      exit (the first, if tied); -1..1. herding is 0 if agents take the nearest exit, and above 0 if agents follow the
      crowd. NaN below two agents.
    - path_efficiency: shortest path from the start to the exit / steps taken; mean; above 0..1. path_efficiency_moving:
      shortest path / moves made.
    - warned: agents that received a warning (as in `warning`) before the step in which they left / out; 0..1.
      warnings_heard: mean number of warnings received before that step.

    Denominators: n_agents, n_out, n_lost, n_leaders_out.
    """
    assert run.left is not None, "a world with exits must record who left"
    agents = run.world.agents
    left_at = np.where((run.left != NO_EXIT).any(axis=0), (run.left != NO_EXIT).argmax(axis=0) + 1, 0)[:agents]
    who = np.flatnonzero(left_at)
    taken, steps = run.left[left_at[who] - 1, who], left_at[who]
    distances = start_distances(run)[:, :agents]
    lost = 0 if run.lost is None else int(run.lost[:, :agents].sum())
    return {
        "out": ratio(len(who), agents),
        "lost": ratio(lost, agents),
        **_times(run, np.sort(steps)),
        **{
            f"share_{way_out.name}": ratio(int((taken == k).sum()), len(who))
            for k, way_out in enumerate(run.world.exits)
        },
        **_choice(run, who, taken, distances),
        "least_crowded": mean(_least_crowded(run, who, taken, steps)),
        "path_efficiency": mean(distances[taken, who] / steps),
        "path_efficiency_moving": mean(distances[taken, who] / run.moved[:, who].sum(axis=0)),
        **_warnings(run, who, steps),
        "n_agents": float(agents),
        "n_out": float(len(who)),
        "n_lost": float(lost),
    }


def _times(run: GridRun, left_at: IntArray) -> dict[str, float]:
    """Return the steps until 90 % and 50 % of the agents are out, with lower bounds; `left_at` is ascending, (n,)."""
    soon, times = soonest(run), dict[str, float]()
    for share_out, suffix in ((0.9, ""), (0.5, "_50")):
        leaving = math.ceil(share_out * run.world.agents - 1e-9)
        time = float(left_at[leaving - 1]) if len(left_at) >= leaving else math.nan
        bound = float(soon[leaving - 1]) if np.isfinite(soon[leaving - 1]) else math.nan
        times |= {f"time{suffix or '_90'}": time, f"lower_bound{suffix}": bound, f"over_bound{suffix}": time / bound}
    return times


def _choice(run: GridRun, who: IntArray, taken: IntArray, distances: IntArray) -> dict[str, float]:
    """Return the measures of the choice of exits.

    Args:
        run: the run.
        who: ids of the agents that got out, (n,).
        taken: index of the exit that each of them took, (n,).
        distances: fewest steps from each agent's start to each exit, (E, N).
    """
    far = np.where(distances == NO_WAY, np.iinfo(np.int64).max, distances)[:, who]
    nearest = far.argmin(axis=0) if len(who) else taken
    leaders = who < (0 if run.world.leaders is None else run.world.leaders.number)
    of_leaders = np.bincount(taken[leaders], minlength=len(run.world.exits))
    followed = taken[~leaders] == of_leaders.argmax() if leaders.any() else np.zeros(0)
    return {
        "nearest": mean(far[taken, np.arange(len(who))] == far.min(axis=0, initial=np.iinfo(np.int64).max)),
        "with_leaders": mean(followed),
        "herding": _same(taken) - _same(nearest),
        "n_leaders_out": float(leaders.sum()),
    }


def _same(taken: IntArray) -> float:
    """Return the share of the pairs of agents with the same exit; NaN below two agents."""
    counts = np.bincount(taken) if len(taken) else np.zeros(1, dtype=np.int64)
    return ratio(int((counts * (counts - 1)).sum()), len(taken) * (len(taken) - 1))


def _least_crowded(run: GridRun, who: IntArray, taken: IntArray, steps: IntArray) -> FloatArray:
    """Return 1 for each agent that took the least crowded exit, else 0, (n,).

    Crowds are counted halfway between the start and the time at which the agent got out.
    """
    half = run.world.half_size
    states = steps // 2
    at = np.array([_crowd(run, state) for state in range(int(states.max(initial=0)) + 1)])
    reachable = exit_steps(run.world)[:, run.x[states, who] + half, run.y[states, who] + half].T != NO_WAY
    crowds = np.where(reachable, at[states], np.iinfo(np.int64).max)
    return np.asarray(crowds[np.arange(len(who)), taken] == crowds.min(axis=1), dtype=np.float64)


def _crowd(run: GridRun, state: int) -> IntArray:
    """Return the number of agents at each exit in a state, (E,)."""
    there = run.there[min(state, run.steps - 1)]
    x, y = run.x[state, there], run.y[state, there]
    crowd = []
    for exit_zone in run.world.exits:
        cells = np.array(exit_zone.cells)
        near = (np.abs(x[:, None] - cells[:, 0]) <= AT_IT) & (np.abs(y[:, None] - cells[:, 1]) <= AT_IT)
        crowd.append(int(near.any(axis=1).sum()))
    return np.array(crowd, dtype=np.int64)


def _warnings(run: GridRun, who: IntArray, steps: IntArray) -> dict[str, float]:
    heard = deliveries_of(run, find_labels(run)[0])
    left_at = np.zeros(run.agents, dtype=np.int64)
    left_at[who] = steps
    before = heard[heard[:, 0] < left_at[heard[:, 2]]]
    counts = np.bincount(before[:, 2], minlength=run.agents)[who]
    return {"warned": mean(counts > 0), "warnings_heard": mean(counts)}
