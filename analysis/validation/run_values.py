"""The values of chosen measures in each run of a sweep."""

import math
from collections.abc import Iterable
from pathlib import Path

from analysis.measuring.runs import Source, measure_run
from foundry.errors import RecordError
from foundry.storing.store import SweepFolder


def values_of(sweep: Path, columns: Iterable[str]) -> dict[str, list[float]]:
    """Return for each of some measures its values in the runs of a sweep, one value per run.

    Raises:
        RecordError: a measure does not exist, or is undefined in a run.
    """
    source = Source(SweepFolder.open(sweep), sweep.name)
    values_by_column: dict[str, list[float]] = {column: [] for column in columns}
    for run in source.folder.runs():
        measures = measure_run(run, source).measures
        for column, values in values_by_column.items():
            values.append(measures.get(column, math.nan))
            if math.isnan(values[-1]):
                raise RecordError(f"The measure {column} has no value in run {run.id} of {sweep}.")
    return values_by_column
