"""Idle rate: how often agents stay in place by choice, at an obstacle, or after an unreadable reply."""

import numpy as np

from analysis.arrays import STAY, BoolArray
from analysis.formulas import longest_run, mean, ratio
from analysis.grid.grid_run import OUTSIDE, GridRun
from analysis.measure import Measure, share

NAME = "idle_rate"

MEASURES = {
    "chosen": share("Chose to stay (share of decisions)", says="stays where it is {more|less} often"),
    "blocked": share(
        "Blocked by the edge or an obstacle (share of decisions)",
        says="runs against the edge or an obstacle {more|less} often",
    ),
    "invalid": share("No readable decision (share of decisions)"),
    "immobile": share("Did not move (share of decisions)"),
    "longest_run": Measure("Most successive steps without a move (mean of agents)", low=0),
    "chosen_in_place": share("Chose to stay in a place (share of decisions there)"),
    "chosen_in_crowd": share("Chose to stay in a crowded place (share of decisions there)"),
    "chosen_near_fire": share("Chose to stay with a fire in sight (share of decisions then)"),
    "immobile_in_place": share("Did not move in a place (share of decisions there)"),
    "immobile_in_crowd": share("Did not move in a crowded place (share of decisions there)"),
    "immobile_near_fire": share("Did not move with a fire in sight (share of decisions then)"),
}

HEADLINE = ("chosen", "blocked", "invalid")


def measure(run: GridRun) -> dict[str, float]:
    """Return the idle rate of a run, over the counted decisions of all agents.

    - chosen: decisions read as `stay` / decisions; 0..1. An agent that draws staying and the four directions with equal
      chances has 1/5.
    - blocked: share of decisions that request a move without effect, at the edge, a wall or a full cell; 0..1.
    - invalid: share of decisions that are unreadable, which leave the agent in place; 0..1.
    - immobile: share of steps without a change of position, the sum of chosen, blocked and invalid; 0..1.
    - longest_run: largest number of successive immobile steps among an agent's counted steps; mean over the agents with
      counted steps; 0..T.
    - chosen_in_place, chosen_in_crowd, chosen_near_fire: `chosen` among the decisions inside a place, inside a place
      over its capacity, and with a perceived fire. NaN without such decisions.
    - immobile_in_place, immobile_in_crowd, immobile_near_fire: `immobile` in the same contexts.

    Gathering, sharing, attacking and reproducing count as movement. NaN without decisions.

    Denominators: n_decisions, n_in_place, n_in_crowd, n_near_fire.
    """
    stay, counted, moved = run.choice == STAY, run.counted, run.moved | run.acted
    contexts = _contexts(run)
    longest = [longest_run(~moved[own, agent]) for agent, own in enumerate(counted.T) if own.any()]
    return {
        **_shares(stay[counted], moved[counted], run.readable[counted]),
        "longest_run": mean(longest),
        **{f"chosen_{name}": mean((stay & run.readable)[rows]) for name, rows in contexts.items()},
        **{f"immobile_{name}": mean(~moved[rows]) for name, rows in contexts.items()},
        **{f"n_{name}": float(rows.sum()) for name, rows in contexts.items()},
    }


def _contexts(run: GridRun) -> dict[str, BoolArray]:
    """Return, for each context such as a crowded place, whether each decision counts and was made in it, (T, N)."""
    place = run.place[:-1]
    crowded = np.zeros(place.shape, dtype=np.bool_)
    for index, world_place in enumerate(run.world.places):
        there = place == index
        crowded |= there & (there.sum(axis=1, keepdims=True) > world_place.capacity)
    return {
        "in_place": (place != OUTSIDE) & run.counted,
        "in_crowd": crowded & run.counted,
        "near_fire": run.perceived & run.counted,
    }


def _shares(stay: BoolArray, moved: BoolArray, readable: BoolArray) -> dict[str, float]:
    """Return the share of decisions that stayed by choice, were blocked, and so on; all arguments are (n,)."""
    decisions = stay.size
    return {
        "chosen": ratio(int((stay & readable).sum()), decisions),
        "blocked": ratio(int((~stay & ~moved).sum()), decisions),
        "invalid": ratio(int((~readable).sum()), decisions),
        "immobile": ratio(int((~moved).sum()), decisions),
        "n_decisions": float(decisions),
    }
