"""The first screen besides its cards: a line of facts, the matrix of models and worlds, what can be claimed."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from analysis.figures.members import Member
from analysis.figures.shown import Shown
from analysis.findings.finding_records import FindingRecord
from analysis.findings.ranking import findings, measures_to_test
from analysis.paper.ending import nothing_claimed, tests_in
from analysis.paper.gaps import short_names
from analysis.paper.sentence import DIFFERENT, Row, kind_of
from analysis.paper.study import new_seeds, telling_apart
from analysis.paper.summary import EXPLORES, HELD_NOT
from analysis.prose import group_label, joined, percent
from analysis.report.cards import Mark, mark
from analysis.report.material import Material
from analysis.stats.contrasts import ALPHA
from analysis.stats.intervals import Estimate
from analysis.tables.texts import with_intervals
from analysis.validation.facts import facts_of
from foundry.texts import counted

UNREADABLE = 0.05
"""Share of unreadable decisions from which the first screen warns of a model."""
MOST_MEASURES = 5
"""Measures that are columns of the matrix of one world."""
MOST_GROUPS = 24
"""Rows of the matrix."""


def facts(found: Material) -> list[str]:
    """Return the parts of the line of facts: what was compared, how many runs, what they took, whether declared."""
    own = [member for member in found.members if not member.shown.baseline]
    compared, groups = found.analysis.compared, [shown.group for shown in found.own]
    levels = {compared.group_columns[at]: len({group[at] for group in groups}) for at in telling_apart(groups)}
    sides = [counted(count, name) for name, count in levels.items() if count > 1 or name == "model"]
    sides.append(counted(len({member.seed for member in own}), "seed"))
    worlds = list(dict.fromkeys(_world(member) for member in own))
    cost = _cost(own)
    claims = set(found.analysis.contrasts["claim"])
    return [
        " x ".join(sides) + (f" in {worlds[0]}" if len(worlds) == 1 else ""),
        f"{sum(member.complete for member in own)} of {len(own)} runs",
        f"{cost.calls:,} calls, {_short(cost.tokens)} tokens, {duration(cost.seconds)} of runs",
        *(["declared" if "declared" in claims else "exploratory"] if claims else []),
    ]


def warnings(found: Material) -> list[str]:
    """Return what weakens everything: models with many unreadable decisions, and a part of the runs."""
    said = [f"only a part of the runs: {found.analysis.filtered}"] if found.analysis.filtered else []
    own = [member for member in found.members if not member.shown.baseline]
    several = len(set(map(_world, own))) > 1
    for model, members in _grouped(own, _model).items():
        shares = {
            world: unreadable / decisions
            for world, played in _grouped(members, _world).items()
            for decisions, unreadable in [_decisions(played)]
            if decisions and unreadable / decisions >= UNREADABLE
        }
        parts = [f"{percent(share)} in {world}" if several else percent(share) for world, share in shares.items()]
        said += [f"Unreadable decisions of {model}: {joined(parts)}"] if parts else []
    return said


@dataclass(frozen=True)
class _Cost:
    calls: int
    tokens: int
    seconds: float


def _cost(members: Sequence[Member]) -> _Cost:
    ends = [member.summary for member in members if member.summary is not None]
    tokens = sum(end.counts.prompt_tokens + end.counts.output_tokens for end in ends)
    return _Cost(sum(end.counts.calls for end in ends), tokens, sum(end.duration_s for end in ends))


def _decisions(members: Sequence[Member]) -> tuple[int, int]:
    return sum(member.decisions for member in members), sum(member.unreadable for member in members)


def _world(member: Member) -> str:
    return str(member.folder.config()["world"]["name"])


def _model(member: Member) -> str:
    return str(member.folder.config()["model"]["name"])


def _grouped(members: Sequence[Member], name_of: Callable[[Member], str]) -> dict[str, list[Member]]:
    groups: dict[str, list[Member]] = {}
    for member in members:
        groups.setdefault(name_of(member), []).append(member)
    return groups


def _short(count: int) -> str:
    """Return a large count in millions or thousands."""
    if count >= 1_000_000:
        return f"{count / 1_000_000:.1f} M"
    return f"{count / 1000:.0f} k" if count >= 10_000 else f"{count:,}"


def duration(seconds: float) -> str:
    """Return a time in hours, minutes or seconds."""
    if seconds >= 3600:
        return f"{seconds / 3600:.1f} h"
    return f"{seconds / 60:.0f} min" if seconds >= 90 else f"{seconds:.0f} s"


@dataclass(frozen=True)
class MatrixCell:
    """A number of the matrix.

    Attributes:
        text: mean and interval, or why there is none.
        reach: where the mean lies from the blind baseline, 0, to the best one, 1; None where neither was run.
        end: `greatest` or `least` of its column where their intervals part; else "".
    """

    text: str
    reach: float | None = None
    end: str = ""


@dataclass(frozen=True)
class MatrixColumn:
    """A head of the matrix, what is measured in it, and the measure's dotted name."""

    title: str
    label: str = ""
    measure: str = ""


@dataclass(frozen=True)
class Matrix:
    """Models by worlds, or by measures where there is one world.

    Attributes:
        caption: how it is read.
        columns: heads of the numbers, then of what the runs took.
        rows: mark of the model, its numbers, then what its runs took.
        more: how many rows have no room.
    """

    caption: str
    columns: tuple[MatrixColumn, ...]
    rows: tuple[tuple[Mark, tuple[MatrixCell, ...], tuple[str, ...]], ...]
    more: int


@dataclass(frozen=True)
class _Column:
    """The estimates of one column by row, and the baselines that they lie between."""

    head: MatrixColumn
    estimates: Mapping[tuple[str, ...], Estimate]
    blind: float = math.nan
    best: float = math.nan


def matrix(found: Material) -> Matrix:
    """Return the matrix of the first screen."""
    worlds = dict.fromkeys(_world(member) for member in found.members if not member.shown.baseline)
    keys = _row_keys(found, several=len(worlds) > 1)
    columns = [_of_world(found, world, keys) for world in worlds] if len(worlds) > 1 else _of_measures(found, keys)
    rows = list(dict.fromkeys(keys.values()))
    cells = [_cells(column, rows) for column in columns]
    heads = ("readable", "calls", "tokens", "time")
    bars = any(cell.reach is not None for column in cells for cell in column)
    return Matrix(
        caption=_caption(several=len(worlds) > 1, bars=bars),
        columns=(*(column.head for column in columns), *map(MatrixColumn, heads)),
        rows=tuple(
            (shown_as, tuple(column[row] for column in cells), _took(found, keys, rows[row]))
            for row, shown_as in enumerate(_marks(found, keys, rows)[:MOST_GROUPS])
        ),
        more=max(0, len(rows) - MOST_GROUPS),
    )


def _caption(*, several: bool, bars: bool) -> str:
    shown = "Each world's own score" if several else "The measures with the largest gaps"
    bar = " A bar leads from the blind baseline (left) to the best scripted one (right)." if bars else ""

    ends = " Bold: greatest; underlined: least, where their intervals part."
    return f"{shown}: mean over seeds [95 % interval].{bar}{ends}"


def _row_keys(found: Material, *, several: bool) -> dict[Shown, tuple[str, ...]]:
    """Return what names the row of each group: all but its world, and but a prompt that goes with the world."""
    columns = found.analysis.compared.group_columns
    known = {shown: dict(zip(columns, shown.group, strict=True)) for shown in found.own}
    pairs = {(own.get("world"), own.get("prompt")) for own in known.values()}
    with_world = {"world", "prompt"} if len(pairs) == len({world for world, _ in pairs}) else {"world"}
    left_out = with_world if several else frozenset()
    return {shown: tuple(value for name, value in own.items() if name not in left_out) for shown, own in known.items()}


def _of_world(found: Material, world: str, keys: Mapping[Shown, tuple[str, ...]]) -> _Column:
    """Return the world's own score by row; without estimates where the world has none."""
    known = facts_of(world)
    if known is None:
        return _Column(MatrixColumn(world, "no score of its own"), {})
    compared, validation = found.analysis.compared, found.analysis.validation
    own = {member.shown for member in found.members if _world(member) == world}
    estimates = {
        key: compared.estimates[known.score, shown.group]
        for shown, key in keys.items()
        if shown in own and (known.score, shown.group) in compared.estimates
    }
    rows = validation[(validation["world"] == world) & (validation["measure"] == known.score)]
    head = MatrixColumn(world, compared.describe(known.score).label, known.score)
    return _Column(head, estimates, _agreed(rows["random"]), _agreed(rows["best"]))


def _agreed(values: pd.Series[float]) -> float:
    """Return the one value that all rows have, or NaN."""
    return float(values.iloc[0]) if len(values) and values.nunique(dropna=False) == 1 else math.nan


def _of_measures(found: Material, keys: Mapping[Shown, tuple[str, ...]]) -> list[_Column]:
    """Return the measures with the largest gaps; the declared ones where nothing is compared."""
    compared = found.analysis.compared
    measures = list(dict.fromkeys(finding.measure for finding in found.analysis.findings)) or found.analysis.declared
    columns = []
    for measure in measures[:MOST_MEASURES]:
        estimates = {
            key: compared.estimates[measure, shown.group]
            for shown, key in keys.items()
            if (measure, shown.group) in compared.estimates
        }
        columns.append(_Column(MatrixColumn(compared.describe(measure).label, measure=measure), estimates))
    return columns


def _cells(column: _Column, rows: Sequence[tuple[str, ...]]) -> list[MatrixCell]:
    """Return the cells of a column; its ends are marked where their intervals part."""
    known = {key: one for key, one in column.estimates.items() if not math.isnan(one.mean)}
    texts = dict(zip(known, with_intervals([(one.mean, one.low, one.high) for one in known.values()]), strict=True))
    greatest, least = (pick(known, key=lambda key: known[key].mean, default=None) for pick in (max, min))
    parted = greatest is not None and least is not None and known[least].high < known[greatest].low
    ends = {greatest: "greatest", least: "least"} if parted else {}
    absent = column.head.label if not column.estimates else "not measured"
    cells = {key: MatrixCell(texts[key], _reach(one.mean, column), ends.get(key, "")) for key, one in known.items()}
    return [cells.get(key, MatrixCell(absent)) for key in rows]


def _reach(mean: float, column: _Column) -> float | None:
    """Return where a mean lies between the baselines, 0 to 1; None where they are not known."""
    if math.isnan(column.blind) or math.isnan(column.best) or column.blind == column.best:
        return None
    return min(1.0, max(0.0, (mean - column.blind) / (column.best - column.blind)))


def _marks(found: Material, keys: Mapping[Shown, tuple[str, ...]], rows: Sequence[tuple[str, ...]]) -> list[Mark]:
    names = short_names(map(group_label, rows))
    return [mark(next(shown for shown in found.own if keys[shown] == key), names[group_label(key)]) for key in rows]


def _took(found: Material, keys: Mapping[Shown, tuple[str, ...]], key: tuple[str, ...]) -> tuple[str, ...]:
    """Return readable share, calls, tokens and time of a row."""
    mine = [member for member in found.members if keys.get(member.shown) == key]
    decisions, unreadable = _decisions(mine)
    cost = _cost(mine)
    readable = percent(1 - unreadable / decisions) if decisions else "not counted"
    return readable, f"{cost.calls:,}", _short(cost.tokens), duration(cost.seconds)


@dataclass(frozen=True)
class Claims:
    """What can be claimed, and the command that would allow more, with what it takes; "" where there is none."""

    sentence: str
    command: str
    cost: str


def claims(found: Material) -> Claims:
    """Return what can be claimed of the declared measures."""
    contrasts = found.analysis.contrasts
    rows = contrasts[contrasts["headline"].astype(bool)].to_dict("records")
    sentence = claimed(rows, found.analysis.findings, planned=found.analysis.planned is not None)
    measures = measures_to_test(findings(rows))
    if not measures or any(finding.stands for finding in found.analysis.findings):
        return Claims(sentence, "", "")
    pairs = len({(row["level"], row["reference"], row["context"]) for row in rows})
    own = [member for member in found.members if not member.shown.baseline]
    seeds = {member.seed for member in own}
    share = new_seeds(len(seeds), pairs, ALPHA) / len(seeds)
    cost = _cost(own)
    takes = f"about {round(share * cost.calls):,} calls, {duration(share * cost.seconds)} of runs"
    return Claims(sentence, found.analysis.on_new_seeds([sweep.path for sweep in found.sweeps], measures, pairs), takes)


def claimed(rows: Sequence[Row], found: Sequence[FindingRecord], *, planned: bool) -> str:
    """Return what can be claimed of declared rows, in a sentence.

    Args:
        rows: rows of contrasts.
        found: the findings in them.
        planned: whether anything was declared before the runs.
    """
    if not rows:
        return "Nothing is compared, so nothing can be claimed."
    different = sum(kind_of(row) == DIFFERENT for row in rows)
    standing = sum(finding.stands for finding in found)
    if standing:
        return f"{counted(standing, 'finding')} can be claimed: declared before the runs, and tested."
    if not different:
        return nothing_claimed(rows)
    said = f"{different} of {counted(tests_in(rows), 'test')} show{'s' * (different == 1)} a difference."
    return f"{said} {HELD_NOT if planned else EXPLORES} A claim needs new runs, declared before:"
