"""Finds the runs that differ most from the other runs of their group."""

import math
from collections.abc import Sequence
from pathlib import Path

import msgspec
import numpy as np
import pandas as pd

from analysis.figures.members import Member
from analysis.findings.study_matrix import Matrix
from analysis.stats.values import Group
from analysis.tables.comparison import Comparison
from analysis.tables.texts import rounded

FEWEST_RUNS = 4
"""Minimum number of runs in a group whose runs are compared with each other."""
MOST = 5
"""Maximum number of runs in the list of the furthest runs."""


class FarRun(msgspec.Struct, frozen=True):
    """A run whose value of one measure is far from the mean of the run's group.

    Attributes:
        measure: name of the measure, such as `exploration.coverage`.
        value: value of the run, as text.
        mean: mean of the run's group, as text.
        distance: distance between the run's value and this mean, in standard deviations within groups.
    """

    run: str
    measure: str
    label: str
    value: str
    mean: str
    distance: float


def furthest(
    compared: Comparison, members: Sequence[Member], table: pd.DataFrame, measures: Sequence[str]
) -> tuple[FarRun, ...]:
    """Return the runs that are furthest from the mean of their group, with the measure in which each run is furthest.

    Distances are in standard deviations within groups, pooled over the groups of a measure.
    """
    by_group: dict[Group, list[int]] = {}
    for place, member in enumerate(members):
        if member.complete and not member.shown.baseline:
            by_group.setdefault(member.shown.group, []).append(place)
    known = (measure for measure in measures if measure in table)
    far = [far_run for measure in known for far_run in _of_measure(measure, compared, members, table, by_group)]
    by_run: dict[str, FarRun] = {}
    for far_run in sorted(far, key=lambda far_run: -far_run.distance):
        by_run.setdefault(far_run.run, far_run)
    return tuple(by_run.values())[:MOST]


def _of_measure(
    measure: str,
    compared: Comparison,
    members: Sequence[Member],
    table: pd.DataFrame,
    by_group: dict[Group, list[int]],
) -> list[FarRun]:
    values = table[measure].to_numpy(dtype=np.float64)
    known = [[place for place in places if not math.isnan(values[place])] for places in by_group.values()]
    groups = [np.array(places) for places in known if len(places) >= FEWEST_RUNS]
    freedom = sum(len(places) - 1 for places in groups)
    squares = sum(float(np.var(values[places])) * len(places) for places in groups)
    if squares == 0:
        return []
    spread, label = math.sqrt(squares / freedom), compared.describe(measure).label
    far_runs = []
    for places in groups:
        mean = float(values[places].mean())
        for place in places.tolist():
            value, average = rounded([values[place], mean])
            if distance := round(float(abs(values[place] - mean)) / spread, 2):
                far_runs.append(FarRun(members[place].folder.id, measure, label, value, average, distance))
    return far_runs


def write_overview(folder: Path, matrix: Matrix, far: Sequence[FarRun], compared: Comparison) -> Path:
    """Write the matrix, the furthest runs and the titles of all measures to `overview.json`; return its path."""
    path = folder / "overview.json"
    labels = {measure: compared.describe(measure).label for measure in dict.fromkeys(compared.frame["measure"])}
    path.write_bytes(msgspec.json.encode({"matrix": matrix, "furthest": far, "labels": labels}) + b"\n")
    return path
