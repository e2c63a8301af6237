"""Finds the first questions that two runs share but decide differently."""

import itertools
from typing import Any

from foundry.storing.store import RunFolder
from foundry.viewer.catalog import CatalogedSweep

MOST = 11
"""Maximum number of such decisions on a page: the first and ten more."""


def partings_of(first: RunFolder, second: RunFolder) -> dict[str, Any]:
    """Return the first questions on which two runs decide differently, as far as both runs are recorded.

    Raises:
        RecordError: a record is damaged.
    """
    from analysis.findings.moments import partings

    found = itertools.islice(partings(first, second), MOST)
    return {"partings": [[one.step, one.agent, one.question, one.asked] for one in found]}


def paired_runs(sweep: CatalogedSweep) -> list[tuple[RunFolder, RunFolder]]:
    """Return the pairs of runs with one world and seed; each pair is sorted by id."""
    worlds = [condition.config["world"]["name"] for condition in sweep.folder.sweep.conditions]
    placed = sorted(
        (worlds[run.condition], run.seed, run.id, folder)
        for run, folder in zip(sweep.folder.sweep.runs, sweep.runs(), strict=True)
    )
    return [
        (first[-1], second[-1])
        for _, runs in itertools.groupby(placed, key=lambda one: one[:2])
        for first, second in itertools.combinations(list(runs), 2)
    ]
