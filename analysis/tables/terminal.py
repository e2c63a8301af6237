"""The short tables of a terminal: the declared measures first, as many columns side by side as fit."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from typing import Any

import pandas as pd

from analysis.stats.factors import MODEL
from analysis.tables.comparison import Comparison
from analysis.tables.table import Table
from analysis.tables.texts import claim_of, comparison_table, p_value, shown_measures, text_width, with_interval
from foundry.texts import counted

MOST_BLOCKS, MOST_BLOCKS_BRIEF = 4, 2
"""Blocks of columns below one another; what would be in a further one is left to the files."""
LONGEST_NAME = 36
"""Letters of a name beyond which its middle is left out."""
_GAP = 2


def means(
    comparison: Comparison, declared: Sequence[str], width: int, *, brief: bool, served: Collection[str] = ()
) -> list[Table]:
    """Return the means by group in blocks, the last with a caption that says what is left out.

    Every group is shown: where its columns do not fit into the blocks, each group has a row.

    Args:
        comparison: the groups.
        declared: the measures that claims rest on, which come first.
        width: columns of the terminal.
        brief: whether to leave out all other measures.
        served: models that a server answers for, which come first; baselines come last.
    """
    described = {measure for measure, _ in comparison.estimates}
    first = [name for name in declared if name in described]
    others = [name for name in shown_measures(comparison) if name not in first]
    table = comparison_table(comparison, first if brief else [*first, *others])
    if not table.rows:
        return []
    places = _in_order(comparison, served)
    heads = shortened(table.columns[1:])
    table = replace(table, columns=(table.columns[0], *(heads[name] for name in table.columns[1:])))
    table = _columns(table, [0, *(1 + place for place in places)])
    shown, cut = _fitting(table, width, MOST_BLOCKS_BRIEF if brief else MOST_BLOCKS, "group", "comparison.md")
    notes = [
        "means [95 % interval] over seeds; n where only some have a value",
        *cut,
        *([f"further measures ({len(others)}) are in comparison.md"] if brief and others else []),
    ]
    return _captioned(shown, notes)


def _in_order(comparison: Comparison, served: Collection[str]) -> list[int]:
    """Return the places of the groups: served models, scripted ones, baselines."""
    groups = comparison.groups

    def rank(place: int) -> int:
        group = groups[place]
        return 2 if group in comparison.baselines else 0 if set(group) & set(served) else 1

    return sorted(range(len(groups)), key=rank)


def differences(contrasts: pd.DataFrame, width: int, *, brief: bool, served: Collection[str] = ()) -> list[Table]:
    """Return the declared differences in blocks, a row a measure and a column a pair; none where there is no pair.

    Args:
        contrasts: the table of contrasts.
        width: columns of the terminal.
        brief: whether to show fewer blocks.
        served: models that a server answers for, whose differences come first.
    """
    rows = contrasts[contrasts["headline"].astype(bool)]
    if rows.empty:
        return []
    short = shortened([*rows["level"].astype(str), *rows["reference"].astype(str)])
    pairs: dict[str, dict[str, str]] = {}
    for row in sorted(rows.to_dict("records"), key=lambda row: -_served_sides(row, served)):
        pairs.setdefault(_pair(row, short), {})[str(row["measure"])] = _cell(row, int(rows["n_pairs"].max()))
    measures = rows["measure"].astype(str).unique()
    cells = tuple((measure, *(pair.get(measure, "") for pair in pairs.values())) for measure in measures)
    most = MOST_BLOCKS_BRIEF if brief else MOST_BLOCKS
    shown, cut = _fitting(Table("contrasts", "", ("measure", *pairs), cells), width, most, "pair", "contrasts.md")
    tests = _tests(rows)
    notes = [
        "differences paired by seed [95 % interval]",
        *dict.fromkeys(claim_of(row) for row in rows.to_dict("records") if not math.isnan(row["p"])),
        *([f"p corrected over {tests}, * where it stands"] if tests else []),
        *cut,
        *(["those from baselines are in contrasts.md"] if contrasts["baseline"].astype(bool).any() else []),
    ]
    return _captioned(shown, notes)


def _tests(rows: pd.DataFrame) -> str:
    """Return over how many measures and pairs each factor's tests are corrected; "" where nothing was tested."""
    tested = rows[rows["family"] > 0].drop_duplicates("factor")
    said = [
        f"{counted(row['family'], 'test')} of {counted(row['pairs'], 'pair')}"
        + (f" ({row['factor']})" if len(tested) > 1 else "")
        for row in tested.to_dict("records")
    ]
    return " and ".join(said)


def _served_sides(row: dict[Any, Any], served: Collection[str]) -> int:
    """Return how many of the two sides of a row are those of served models."""
    if row["factor"] == MODEL:
        return sum(row[name] in served for name in ("level", "reference"))
    return 2 * any(f"{MODEL}={name}" in str(row["context"]).split(", ") for name in served)


def shortened(names: Iterable[str], most: int = LONGEST_NAME) -> dict[str, str]:
    """Return the names without their middle where they are longer than that, and longer where two would be alike."""
    every, half = list(dict.fromkeys(names)), most // 2
    found = {name: name if len(name) <= most else f"{name[:half]}…{name[1 - half :]}" for name in every}
    return found if len(set(found.values())) == len(every) else shortened(every, most + 4)


def _fitting(table: Table, width: int, most: int, rows: str, where: str) -> tuple[list[Table], list[str]]:
    """Return the table in blocks; where not all columns fit into so many, with rows and columns exchanged.

    Beside it stands a note of the measures that even so have no room, if there are such.

    Args:
        table: one column of names, the others of numbers.
        width: columns of the terminal.
        most: blocks.
        rows: what each row is, should they be exchanged.
        where: the file that has all measures.
    """
    shown = blocks(table, width, most)
    if _columns_of(shown) == len(table.columns) - table.labels:
        return shown, []
    names, *numbers = zip(*table.rows, strict=True)
    flat = (" ".join(head.split("\n")) for head in table.columns[1:])
    turned = tuple((head, *column) for head, column in zip(flat, numbers, strict=True))
    shown = blocks(replace(table, columns=(rows, *names), rows=turned), width, most)
    seen = _columns_of(shown)
    return shown, [f"{seen} of {len(names)} measures, all are in {where}"] if seen < len(names) else []


def in_blocks(table: Table, width: int) -> list[Table]:
    """Return a table in blocks of columns that fit into the width, its caption below the last."""
    return _captioned(blocks(table, width, MOST_BLOCKS), [table.caption])


def blocks(table: Table, width: int, most: int) -> list[Table]:
    """Return the first blocks of columns of a table that fit into the width, each behind the names of its rows.

    A row that has nothing in a block is left out of it: of worlds beside each other, most have few measures in common.

    Args:
        table: what to show.
        width: columns of the terminal; a block has one column of numbers at least.
        most: blocks.
    """
    widths = [_width([column, *(row[at] for row in table.rows)]) for at, column in enumerate(table.columns)]
    names = list(range(table.labels))
    left = width - sum(widths[at] + _GAP for at in names)
    parts: list[list[int]] = []
    room = 0
    for at in range(table.labels, len(table.columns)):
        if not parts or widths[at] > room:
            parts.append([])
            room = left
        parts[-1].append(at)
        room -= widths[at] + _GAP
    return [_columns(table, [*names, *part]) for part in parts[:most]]


def _columns(table: Table, kept: Sequence[int]) -> Table:
    parts = (tuple(row[at] for at in kept) for row in table.rows)
    rows = tuple(row for row in parts if any(row[table.labels :]))
    return replace(table, columns=tuple(table.columns[at] for at in kept), rows=rows)


def _width(texts: Sequence[str]) -> int:
    return max(text_width(line) for text in texts for line in text.split("\n"))


def _columns_of(shown: Sequence[Table]) -> int:
    return sum(len(table.columns) - table.labels for table in shown)


def _captioned(shown: Sequence[Table], notes: Sequence[str]) -> list[Table]:
    return [*(replace(table, caption="") for table in shown[:-1]), replace(shown[-1], caption="; ".join(notes))]


def _pair(row: dict[Any, Any], short: dict[str, str]) -> str:
    context = f"\n({row['context']})" if row["context"] else ""
    return f"{short[str(row['level'])]}\n- {short[str(row['reference'])]}{context}"


def _cell(row: dict[Any, Any], most: int) -> str:
    """Return the difference with its interval, n where it is less than elsewhere, and p with its mark."""
    number = with_interval(float(row["difference"]), float(row["low"]), float(row["high"]))
    few = f" n={row['n_pairs']}" if 0 < row["n_pairs"] < most else ""
    p = p_value(float(row["p_adjusted"]))
    mark = ("*" if row["significant"] else "") + ("~" if row["equivalent"] else "")
    said = "" if p == "-" else f" p{p}" if p.startswith("<") else f" p={p}"
    return number + few + said + mark
