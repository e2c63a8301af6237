"""Builds a table of all groups: one row per group, one column per world; for a single world, one column per measure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import msgspec
import pandas as pd

from analysis.figures.measures import agreed
from analysis.figures.members import Member
from analysis.figures.shown import ShownGroup
from analysis.paper.gaps import short_names
from analysis.prose import group_label
from analysis.stats.intervals import Estimate
from analysis.stats.values import Group
from analysis.tables.comparison import Comparison
from analysis.tables.texts import with_intervals
from analysis.validation.facts import facts_of

MOST_MEASURES = 5
"""If there is only one world, the matrix shows at most this number of measures."""


class MatrixCell(msgspec.Struct, frozen=True):
    """A cell of the matrix.

    Attributes:
        text: mean and interval, or the reason why there is no mean.
        reach: position of the mean between the blind baseline (0) and the best baseline (1); None if one is unknown.
        end: `greatest` or `least` for the two extremes of its column, if their intervals do not overlap; else "".
    """

    text: str
    reach: float | None = None
    end: str = ""


class MatrixColumn(msgspec.Struct, frozen=True):
    """A column of the matrix.

    Attributes:
        measure: name of the measure, such as `exploration.coverage`.
        world: world of the column; "" for several.
        blind: score of the blind baseline in the world; None if unknown.
        best: score of the best scripted policy in the world; None if unknown.
    """

    title: str
    label: str = ""
    measure: str = ""
    world: str = ""
    blind: float | None = None
    best: float | None = None


class MatrixRow(msgspec.Struct, frozen=True):
    """A row of the matrix: one model with its settings.

    Attributes:
        groups: groups in the row, one per world.
    """

    name: str
    groups: tuple[Group, ...]
    cells: tuple[MatrixCell, ...]


class Matrix(msgspec.Struct, frozen=True):
    """The matrix.

    Attributes:
        columns: the worlds, or the measures of the only world.
        rows: the rows, in the order of the models' first runs.
    """

    caption: str
    columns: tuple[MatrixColumn, ...]
    rows: tuple[MatrixRow, ...]


@dataclass(frozen=True)
class _Column:
    head: MatrixColumn
    estimates: Mapping[Group, Estimate]
    blind: float = math.nan
    best: float = math.nan


def matrix(
    compared: Comparison,
    shown: Sequence[ShownGroup],
    members: Sequence[Member],
    validation: pd.DataFrame,
    measures: Sequence[str],
) -> Matrix:
    """Return a table with a row per group and a column per world.

    With only one world, it has a column for each of the first MOST_MEASURES measures.
    """
    worlds = _worlds(members)
    names = list(dict.fromkeys(worlds.values()))
    keys = _row_keys(
        compared.group_columns, [condition for condition in shown if not condition.baseline], several=len(names) > 1
    )
    if len(names) > 1:
        columns = [
            _of_world(
                world,
                compared,
                {condition: key for condition, key in keys.items() if worlds.get(condition) == world},
                validation,
            )
            for world in names
        ]
    else:
        columns = [_of_measure(measure, compared, keys, names) for measure in measures[:MOST_MEASURES]]
    rows = list(dict.fromkeys(keys.values()))
    cells = [_cells(column, rows) for column in columns]
    labels = short_names(map(group_label, rows))
    return Matrix(
        _caption(several=len(names) > 1, bars=any(cell.reach is not None for column in cells for cell in column)),
        tuple(column.head for column in columns),
        tuple(
            MatrixRow(
                labels[group_label(key)],
                tuple(condition.group for condition, own in keys.items() if own == key),
                tuple(column[row] for column in cells),
            )
            for row, key in enumerate(rows)
        ),
    )


def _worlds(members: Sequence[Member]) -> dict[ShownGroup, str]:
    first = {member.shown: member.folder for member in reversed(members) if not member.shown.baseline}
    return {shown: str(folder.config()["world"]["name"]) for shown, folder in reversed(first.items())}


def _caption(*, several: bool, bars: bool) -> str:
    shown = "The score of each world" if several else "The measures with the largest gaps"
    bar = " Bar: the mean, between the blind baseline (left) and the best scripted policy (right)." if bars else ""
    ends = " The greatest value is bold and the smallest is underlined, if their intervals do not overlap."
    return f"{shown}: mean over seeds [95 % interval].{bar}{ends}"


def _row_keys(columns: Sequence[str], shown: Sequence[ShownGroup], *, several: bool) -> dict[ShownGroup, Group]:
    """Return for each group the settings that identify its row.

    With several worlds, the world is left out, and also the prompt if every world has only one prompt.
    """
    known = {condition: dict(zip(columns, condition.group, strict=True)) for condition in shown}
    pairs = {(own.get("world"), own.get("prompt")) for own in known.values()}
    with_world = {"world", "prompt"} if len(pairs) == len({world for world, _ in pairs}) else {"world"}
    left_out = with_world if several else frozenset()
    return {
        condition: tuple(value for name, value in own.items() if name not in left_out)
        for condition, own in known.items()
    }


def _of_world(world: str, compared: Comparison, keys: Mapping[ShownGroup, Group], validation: pd.DataFrame) -> _Column:
    known = facts_of(world)
    if known is None:
        return _Column(MatrixColumn(world, "has no score", world=world), {})
    rows = validation[(validation["world"] == world) & (validation["measure"] == known.score)]
    blind, best = (agreed(rows[name]) for name in ("random", "best"))
    ends = {name: None if math.isnan(end) else end for name, end in (("blind", blind), ("best", best))}
    head = MatrixColumn(world, compared.describe(known.score).label, known.score, world, **ends)
    return _Column(head, _estimates(known.score, compared, keys), blind, best)


def _of_measure(measure: str, compared: Comparison, keys: Mapping[ShownGroup, Group], worlds: Sequence[str]) -> _Column:
    head = MatrixColumn(compared.describe(measure).label, measure=measure, world="".join(worlds))
    return _Column(head, _estimates(measure, compared, keys))


def _estimates(measure: str, compared: Comparison, keys: Mapping[ShownGroup, Group]) -> dict[Group, Estimate]:
    return {
        key: compared.estimates[measure, condition.group]
        for condition, key in keys.items()
        if (measure, condition.group) in compared.estimates
    }


def _cells(column: _Column, rows: Sequence[Group]) -> list[MatrixCell]:
    known = {key: estimate for key, estimate in column.estimates.items() if not math.isnan(estimate.mean)}
    texts = dict(
        zip(
            known,
            with_intervals([(estimate.mean, estimate.low, estimate.high) for estimate in known.values()]),
            strict=True,
        )
    )
    greatest, least = (pick(known, key=lambda key: known[key].mean, default=None) for pick in (max, min))
    parted = greatest is not None and least is not None and known[least].high < known[greatest].low
    ends = {greatest: "greatest", least: "least"} if parted else {}
    absent = column.head.label if not column.estimates else "not measured"
    cells = {
        key: MatrixCell(texts[key], _reach(estimate.mean, column), ends.get(key, "")) for key, estimate in known.items()
    }
    return [cells.get(key, MatrixCell(absent)) for key in rows]


def _reach(mean: float, column: _Column) -> float | None:
    if math.isnan(column.blind) or math.isnan(column.best) or column.blind == column.best:
        return None
    return min(1.0, max(0.0, (float(mean) - column.blind) / (column.best - column.blind)))
