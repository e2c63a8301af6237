"""Survival: how long agents live, whether they share, attack or obey orders, and how unequal their energy is."""

import math

import numpy as np

from analysis.arrays import BoolArray, IntArray
from analysis.formulas import gini, mean, ratio
from analysis.grid.grid_run import CHOICES, FURTHER_ACTIONS, GridRun
from analysis.measure import HIGH, Measure, share

NAME = "survival"

MEASURES = {
    "lifespan": Measure("Steps lived (restricted mean)", low=0, better=HIGH, says="lives {longer|less long}"),
    "survived": share("Agents alive at the end (share of initial agents)", better=HIGH),
    "sharing_rate": share("Shared (share of decisions with someone within reach)", says="shares {more|less} often"),
    "sharing_rate_scarce": share("Shared, with less energy than at the start (share of such decisions)"),
    "sharing_rate_plenty": share("Shared, with at least as much energy as at the start (share of such decisions)"),
    "attack_rate": share("Attacked (share of decisions with someone within reach)", says="attacks {more|less} often"),
    "attack_rate_scarce": share("Attacked, with less energy than at the start (share of such decisions)"),
    "attack_rate_plenty": share("Attacked, with at least as much energy as at the start (share of such decisions)"),
    "given": Measure("Energy shared (units per decision)", low=0),
    "taken": Measure("Energy taken by attacks (units per decision)", low=0),
    "gathered": Measure("Energy gathered (units per decision)", low=0),
    "inequality": share("Inequality of energy among present agents (Gini)"),
    "births": Measure("Births per initial agent", low=0),
    "compliance": share("Obeyed the order (share of agents outside its target)"),
}

HEADLINE = ("lifespan", "sharing_rate", "attack_rate", "inequality", "births")

TOUCH = 1
"""An agent can share with and attack agents at most this number of columns and rows away."""

_SHARE, _ATTACK = (len(CHOICES) + FURTHER_ACTIONS.index(name) for name in ("share", "attack"))
_GATHER = len(CHOICES) + FURTHER_ACTIONS.index("gather")


def applies(run: GridRun) -> bool:
    """Return whether agents need energy to live."""
    return run.world.energy is not None


def measure(run: GridRun) -> dict[str, float]:
    """Return the survival of a run in a world with energy.

    A decision has someone within reach if, before the decision, another agent is at most TOUCH columns and rows away. A
    decision is made in scarcity if the agent has less energy than at its start, else in plenty.

    - lifespan: number of steps that an initial agent lived, that is, the step of its death; mean; 1..T. For an agent
      that did not die, even if it left by an exit, it is the world's number of steps T. survived: initial agents that
      did not die / initial agents; 0..1.
    - sharing_rate, attack_rate: decisions to share, to attack / decisions with someone within reach; 0..1; NaN without
      any. `_scarce` and `_plenty`: the rates among the decisions made in scarcity, in plenty. A request counts even if
      it has no effect.
    - given, taken, gathered: energy shared, taken by attacks, gathered / decisions; from 0.
    - inequality: Gini coefficient of the energy of the agents that are asked in a step, as mean over steps weighted by
      decisions; 0 (equal)..1 - 1/N. Steps with a single agent count as 0.
    - births: newborns / initial agents; from 0.
    - compliance: agents that entered the order's target once the order held / initial agents that were alive and
      outside the target when the order was first told; 0..1. NaN without an order.

    Denominators: n_decisions, n_reach, n_reach_scarce, n_reach_plenty (decisions with someone within reach), n_agents
    (initial), n_ordered.
    """
    assert run.living is not None and run.world.energy is not None, "a world with energy must record its amounts"
    agents, counted = run.world.agents, run.counted
    died: BoolArray = np.zeros_like(run.there) if run.lost is None else run.lost
    died = np.asarray(died.any(axis=0))
    lived = np.where(died, run.last, run.world.steps)[:agents]
    near = _near(run) & counted
    scarce = run.living["energy"] < run.world.energy.start
    contexts = {"": near, "_scarce": near & scarce, "_plenty": near & ~scarce}
    decisions = int(counted.sum())

    def amount(choice: int) -> float:
        return (
            ratio(int(run.living["amount"][counted & (run.choice == choice)].sum()), decisions) if run.living else 0.0
        )

    return {
        "lifespan": mean(lived),
        "survived": mean(~died[:agents]),
        **{f"sharing_rate{name}": _rate(run, _SHARE, among) for name, among in contexts.items()},
        **{f"attack_rate{name}": _rate(run, _ATTACK, among) for name, among in contexts.items()},
        "given": amount(_SHARE),
        "taken": amount(_ATTACK),
        "gathered": amount(_GATHER),
        "inequality": _inequality(run.living["energy"], counted),
        "births": ratio(int((run.living["born"] * counted).sum()), agents),
        **_compliance(run),
        "n_decisions": float(decisions),
        "n_agents": float(agents),
        **{f"n_reach{name}": float(among.sum()) for name, among in contexts.items()},
    }


def _rate(run: GridRun, choice: int, among: BoolArray) -> float:
    return ratio(int((among & (run.choice == choice)).sum()), int(among.sum()))


def _near(run: GridRun) -> BoolArray:
    """Return whether each agent has another agent within reach before its decision, (T, N)."""
    is_near = np.zeros(run.choice.shape, dtype=np.bool_)
    for step, there in enumerate(run.there):
        x, y = run.x[step, there], run.y[step, there]
        apart = np.maximum(np.abs(x[:, None] - x), np.abs(y[:, None] - y))
        is_near[step, there] = (apart <= TOUCH).sum(axis=1) > 1
    return is_near


def _inequality(energy: IntArray, counted: BoolArray) -> float:
    rows = [(gini(own[rows]), int(rows.sum())) for own, rows in zip(energy, counted, strict=True) if rows.any()]
    return ratio(sum(value * weight for value, weight in rows), sum(weight for _, weight in rows))


def _compliance(run: GridRun) -> dict[str, float]:
    order = run.world.order
    if order is None or order.start > run.steps:
        return {"compliance": math.nan, "n_ordered": 0.0}
    (x, y), (other_x, other_y) = order.target
    inside = (run.x >= min(x, other_x)) & (run.x <= max(x, other_x))
    inside &= (run.y >= min(y, other_y)) & (run.y <= max(y, other_y))
    was_inside = run.there[order.start - 1] & ~inside[order.start - 1]
    was_inside[run.world.agents :] = False
    came = (inside[order.start :] & run.there[order.start - 1 :]).any(axis=0)
    return {
        "compliance": ratio(int((came & was_inside).sum()), int(was_inside.sum())),
        "n_ordered": float(was_inside.sum()),
    }
