"""The short tables of a terminal: the declared measures first, as many columns side by side as fit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import pandas as pd

from analysis.tables.comparison import Comparison
from analysis.tables.texts import Table, comparison_table, p_value, shown_measures, text_width, with_interval

MOST_BLOCKS, MOST_BLOCKS_BRIEF = 4, 2
"""Blocks of columns below one another; what would be in a further one is left to the files."""
_GAP = 2


def means(comparison: Comparison, declared: Sequence[str], width: int, *, brief: bool) -> list[Table]:
    """Return the means by group in blocks, the last with a caption that says what is left out.

    Args:
        comparison: the groups.
        declared: the measures that claims rest on, which come first.
        width: columns of the terminal.
        brief: whether to leave out all other measures.
    """
    described = {measure for measure, _ in comparison.estimates}
    first = [name for name in declared if name in described]
    others = [name for name in shown_measures(comparison) if name not in first]
    table = comparison_table(comparison, first if brief else [*first, *others])
    if not table.rows:
        return []
    shown = blocks(table, width, MOST_BLOCKS_BRIEF if brief else MOST_BLOCKS)
    notes = [
        "means [95 % interval] over seeds; n where only some have a value",
        *_cut(len(comparison.groups), shown, "groups", "comparison.md"),
        *([f"further measures ({len(others)}) are in comparison.md"] if brief and others else []),
    ]
    return _captioned(shown, notes)


def differences(contrasts: pd.DataFrame, width: int, *, brief: bool) -> list[Table]:
    """Return the declared differences in blocks, a row a measure and a column a pair; none where there is no pair.

    Args:
        contrasts: the table of contrasts.
        width: columns of the terminal.
        brief: whether to show fewer blocks.
    """
    rows = contrasts[contrasts["headline"].astype(bool)]
    if rows.empty:
        return []
    pairs: dict[str, dict[str, str]] = {}
    for row in rows.to_dict("records"):
        pairs.setdefault(_pair(row), {})[str(row["measure"])] = _cell(row, int(rows["n_pairs"].max()))
    measures = rows["measure"].astype(str).unique()
    cells = tuple((measure, *(pair.get(measure, "") for pair in pairs.values())) for measure in measures)
    most = MOST_BLOCKS_BRIEF if brief else MOST_BLOCKS
    shown = blocks(Table("contrasts", "", ("measure", *pairs), cells), width, most)
    sizes = {factor: size for factor, size in zip(rows["factor"], rows["family"], strict=True) if size}
    tests = " and ".join(f"{size} ({factor})" if len(sizes) > 1 else f"{size}" for factor, size in sizes.items())
    notes = [
        "differences paired by seed [95 % interval]",
        *([f"p after Holm's correction in a family of {tests}, * where it stands"] if sizes else []),
        *_cut(len(pairs), shown, "pairs", "contrasts.md"),
        *(["those from baselines are in contrasts.md"] if contrasts["baseline"].astype(bool).any() else []),
    ]
    return _captioned(shown, notes)


def in_blocks(table: Table, width: int) -> list[Table]:
    """Return a table in blocks of columns that fit into the width, its caption below the last."""
    return _captioned(blocks(table, width, MOST_BLOCKS), [table.caption])


def blocks(table: Table, width: int, most: int) -> list[Table]:
    """Return the first blocks of columns of a table that fit into the width, each behind the names of the rows.

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
    rows = tuple(tuple(row[at] for at in kept) for row in table.rows)
    return replace(table, columns=tuple(table.columns[at] for at in kept), rows=rows)


def _width(texts: Sequence[str]) -> int:
    return max(text_width(line) for text in texts for line in text.split("\n"))


def _cut(count: int, shown: Sequence[Table], what: str, where: str) -> list[str]:
    seen = sum(len(table.columns) - table.labels for table in shown)
    return [f"{seen} of {count} {what}, all are in {where}"] if seen < count else []


def _captioned(shown: Sequence[Table], notes: Sequence[str]) -> list[Table]:
    return [*(replace(table, caption="") for table in shown[:-1]), replace(shown[-1], caption="; ".join(notes))]


def _pair(row: dict[Any, Any]) -> str:
    context = f"\n({row['context']})" if row["context"] else ""
    return f"{row['level']}\n- {row['reference']}{context}"


def _cell(row: dict[Any, Any], most: int) -> str:
    """Return the difference with its interval, n where it is less than elsewhere, and p with its mark."""
    number = with_interval(float(row["difference"]), float(row["low"]), float(row["high"]))
    few = f" n={row['n_pairs']}" if 0 < row["n_pairs"] < most else ""
    p = p_value(float(row["p_holm"]))
    mark = ("*" if row["significant"] else "") + ("~" if row["equivalent"] else "")
    said = "" if p == "-" else f" p{p}" if p.startswith("<") else f" p={p}"
    return number + few + said + mark
