"""Reads runs of any form by the keys that all forms have, as arrays or as choices by step and agent."""

import numpy as np

from analysis.any.any_arrays import any_run
from analysis.any.any_run import AnyRun
from analysis.form import Decisions, Records
from foundry.storing.matching import numbered
from foundry.storing.store import RunFolder


def general_run(folder: RunFolder, records: Records) -> AnyRun:
    """Return a complete run of any form as arrays.

    Raises:
        RecordError: a decision does not fit the world's schema, or the steps are not in order.
    """
    return any_run(folder, folder.declared, records.decisions(), records.messages)


def choices(run: AnyRun, codes: dict[str, int]) -> dict[str, Decisions]:
    """Return the actions of a run by kind of question; where an agent was not asked, the action counts as unreadable.

    Args:
        run: the run.
        codes: index of each choice by its text; new choices are added to it, so that several runs share the indices.
    """
    actions = (number if label is None else label for label, number in zip(run.action, run.number, strict=True))
    chosen = np.array([codes.setdefault(str(action), len(codes)) for action in actions], dtype=np.int64)
    places = zip(run.step.tolist(), run.agent.tolist(), run.kind.tolist(), strict=True)
    asked_before = np.array([again for (_, again), _ in numbered(places, lambda place: place)], dtype=np.int64)
    by_kind: dict[str, Decisions] = {}
    for kind in dict.fromkeys(run.kind.tolist()):
        own = run.kind == kind
        at = (run.step[own] - 1, run.agent[own], asked_before[own])
        shape = (int(run.step.max(initial=0)), run.agents, int(at[-1].max(initial=0)) + 1)
        choice, readable = np.zeros(shape, dtype=np.int64), np.zeros(shape, dtype=np.bool_)
        choice[at], readable[at] = chosen[own], run.readable[own]
        by_kind[kind] = Decisions(choice, readable)
    return by_kind
