"""Runs of every form by what all forms have: as arrays, and as choices at each step."""

from __future__ import annotations

import numpy as np

from analysis.any.arrays import any_run
from analysis.any.run import AnyRun
from analysis.form import Decisions, Records
from foundry.storing.store import RunFolder


def general_run(folder: RunFolder, records: Records) -> AnyRun:
    """Return a complete run of whatever form as arrays of the keys that all forms have.

    Raises:
        RecordError: a decision is not what the world declares, or the steps are not in order.
    """
    return any_run(folder, folder.declared, records.decisions(), records.messages)


def choices(run: AnyRun) -> dict[str, Decisions]:
    """Return the actions of a run by kind of question; what an agent was not asked at a step is not readable."""
    chosen = np.unique([str(one) for one in _actions(run)], return_inverse=True)[1]
    found: dict[str, Decisions] = {}
    for kind in dict.fromkeys(run.kind.tolist()):
        own = run.kind == kind
        shape = (int(run.step.max(initial=0)), run.agents)
        choice, readable = np.zeros(shape, dtype=np.int64), np.zeros(shape, dtype=np.bool_)
        at = (run.step[own] - 1, run.agent[own])
        choice[at], readable[at] = chosen[own], run.readable[own]
        found[kind] = Decisions(choice, readable)
    return found


def _actions(run: AnyRun) -> list[object]:
    return [label if label is not None else number for label, number in zip(run.action, run.number, strict=True)]
