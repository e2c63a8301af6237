"""Idle rate: how often agents do nothing, by choice or because no decision was readable."""

import numpy as np

from analysis.any.any_run import AnyRun
from analysis.arrays import BoolArray
from analysis.formulas import ratio
from analysis.measure import share

NAME = "idle_rate"

MEASURES = {
    "chosen": share("Chose to do nothing (share of decisions)", says="does nothing {more|less} often"),
    "invalid": share("No readable decision (share of decisions)"),
}

HEADLINE = ("chosen", "invalid")


def measure(run: AnyRun) -> dict[str, float]:
    """Return the idle rate of a run, over the counted decisions of all agents.

    An idle action does nothing. Only decisions of kinds with a declared idle action count.

    - chosen: decisions read as the idle action / decisions; 0..1.
    - invalid: decisions that could not be read / decisions; 0..1.

    NaN without decisions, and in a world that declares no idle action. Denominator: n_decisions.
    """
    idle = {kind: actions.idle for kind, actions in run.declared.actions.items() if actions.idle is not None}
    asked = np.isin(run.kind, list(idle)) & run.counted
    chosen = asked & run.readable & _does_nothing(run, idle)
    decisions = int(asked.sum())
    return {
        "chosen": ratio(int(chosen.sum()), decisions),
        "invalid": ratio(int((asked & ~run.readable).sum()), decisions),
        "n_decisions": float(decisions),
    }


def _does_nothing(run: AnyRun, idle: dict[str, str | float]) -> BoolArray:
    does_nothing = np.zeros(run.decisions, dtype=np.bool_)
    for kind, action in idle.items():
        does_nothing |= (run.kind == kind) & ((run.action if isinstance(action, str) else run.number) == action)
    return does_nothing
