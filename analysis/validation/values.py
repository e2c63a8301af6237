"""The values of one measure, a run at a time."""

from __future__ import annotations

import math
from pathlib import Path

from analysis.measuring.runs import Source, measure_run
from foundry.errors import RecordError
from foundry.storing.store import SweepFolder


def values_of(sweep: Path, column: str) -> list[float]:
    """Return what a measure came to in each run of a sweep.

    Raises:
        RecordError: there is no such measure, or it is not defined in a run.
    """
    source = Source(sweep, sweep.name)
    found = []
    for run in SweepFolder.open(sweep).runs():
        value = measure_run(run, source).measures.get(column, math.nan)
        if math.isnan(value):
            raise RecordError(f"run {run.id} in {sweep} has no {column}.")
        found.append(value)
    return found
