"""The tables of an analysis as texts, and written as CSV, Parquet, LaTeX and Markdown."""

from __future__ import annotations

import csv
import io
import math
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pandas as pd

from analysis.prose import group_label
from analysis.signatures import discover
from analysis.stats.intervals import Estimate
from analysis.tables.comparison import Comparison

_LATEX = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "$": r"\$",
    "&": r"\&",
    "#": r"\#",
    "%": r"\%",
    "_": r"\_",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    "\N{MINUS SIGN}": "--",
}
_ROUNDING = 1e-12
_WHOLE = 1_000
"""From where on numbers are written to the last whole digit."""
_MARKDOWN = "\\`*_{}[]<>|#~"


SUFFIXES = (".csv", ".parquet", ".tex", ".md")
"""Of the files of a table."""


@dataclass(frozen=True)
class Table:
    """A table of texts; the first `labels` columns are names, the others numbers."""

    name: str
    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    labels: int = 1


def shown_measures(comparison: Comparison) -> list[str]:
    """Return the headline measures that any group has, cost among them."""
    present = list(dict.fromkeys(measure for measure, _ in comparison.estimates))
    return [column for signature in discover() for column in signature.headline_columns(present)]


def comparison_table(comparison: Comparison, measures: Sequence[str] | None = None) -> Table:
    """Return measures by group: mean and 95 % interval, and n where seeds have no value; by default the headlines."""
    groups = comparison.groups
    measures = shown_measures(comparison) if measures is None else measures
    seeds = {group: len(values) for group, values in comparison.values.items()}
    rows = [
        (measure, *(mean_cell(comparison.estimates.get((measure, group)), seeds[group]) for group in groups))
        for measure in measures
    ]
    names = (group_label(group) + (" (baseline)" if group in comparison.baselines else "") for group in groups)
    caption = "Mean over seeds with its 95 % interval; n where not every seed has a value."
    return Table("comparison", caption, ("measure", *names), tuple(rows))


def contrast_table(contrasts: pd.DataFrame) -> Table:
    """Return the differences of the declared family, with p after Holm and a star where they stand.

    Below them stand the same measures against the baselines, which are not tested.
    """
    family = contrasts["headline"].astype(bool)
    measures = set(contrasts.loc[family, "measure"])
    others = contrasts["baseline"].astype(bool) & contrasts["measure"].isin(measures)
    rows = [_contrast_row(row) for row in pd.concat([contrasts[family], contrasts[others]]).to_dict("records")]
    caption = (
        "Differences paired by seed: mean with its 95 % interval, p after Holm's correction over the family "
        "(* significant, ~ the same within the declared margin), Hedges' g of the differences, and the share of "
        "seeds in which the first is greater."
    )
    columns = ("measure", "first", "second", "context", "pairs", "difference", "p (Holm)", "g", "P(first > second)")
    return _without_empty(Table("contrasts", caption, columns, tuple(rows), labels=4))


def _without_empty(table: Table) -> Table:
    """Return the table without those columns of names that are empty in every row."""
    kept = [
        index
        for index in range(len(table.columns))
        if index >= table.labels or not table.rows or any(row[index] for row in table.rows)
    ]
    return replace(
        table,
        columns=tuple(table.columns[index] for index in kept),
        rows=tuple(tuple(row[index] for index in kept) for row in table.rows),
        labels=sum(index < table.labels for index in kept),
    )


def _contrast_row(row: Mapping[Any, Any]) -> tuple[str, ...]:
    value = {key: float(row[key]) for key in ("difference", "low", "high", "p_holm", "g_z", "superiority")}
    mark = ("*" if row["significant"] else "") + ("~" if row["equivalent"] else "")
    return (
        str(row["measure"]),
        str(row["level"]),
        str(row["reference"]),
        str(row["context"]),
        str(row["n_pairs"]),
        with_interval(value["difference"], value["low"], value["high"]),
        p_value(value["p_holm"]) + mark if not math.isnan(value["p_holm"]) else str(row["test"]),
        number(value["g_z"]),
        number(value["superiority"]),
    )


def mean_cell(found: Estimate | None, seeds: int) -> str:
    """Return a mean with its interval; `seeds` are those asked for. Empty where the group has no such measure."""
    if found is None:
        return ""
    return with_interval(found.mean, found.low, found.high) + (f" n={found.n}" if 0 < found.n < seeds else "")


def with_interval(mean: float, low: float, high: float) -> str:
    """Return a number with its interval, where there is one."""
    return number(mean) + ("" if math.isnan(low) else f" [{number(low)}, {number(high)}]")


def number(value: float) -> str:
    """Return a number with three digits that matter; a hyphen for what is undefined, 0 for the rounding of sums."""
    if math.isnan(value):
        return "-"
    if abs(value) >= _WHOLE:
        return f"{value:.0f}"
    return f"{value:.3g}" if abs(value) > _ROUNDING else "0"


def p_value(p: float) -> str:
    """Return a p value with three digits at most."""
    return "-" if math.isnan(p) else "<.001" if p < 0.001 else f"{p:.3f}".lstrip("0")


def to_text(table: Table) -> str:
    """Return the table for a terminal: columns aligned, wide letters counted as two."""
    every = [table.columns, *table.rows]
    widths = [max(text_width(row[index]) for row in every) for index in range(len(table.columns))]
    lines = (
        "  ".join(
            text + " " * (width - text_width(text)) if index < table.labels else " " * (width - text_width(text)) + text
            for index, (text, width) in enumerate(zip(row, widths, strict=True))
        )
        for row in every
    )
    return "".join(line.rstrip() + "\n" for line in lines)


def to_csv(table: Table) -> str:
    """Return the texts of the table as CSV."""
    written = io.StringIO()
    csv.writer(written, lineterminator="\n").writerows([table.columns, *table.rows])
    return written.getvalue()


def to_markdown(table: Table) -> str:
    """Return the table as Markdown, its caption below it."""
    rule = ["---" if index < table.labels else "---:" for index in range(len(table.columns))]
    rows = [[_markdown(text) for text in row] for row in (table.columns, *table.rows)]
    lines = [f"| {' | '.join(row)} |" for row in (rows[0], rule, *rows[1:])]
    return "\n".join([*lines, "", _markdown(table.caption), ""])


def to_latex(table: Table) -> str:
    r"""Return a `table` environment that needs `\usepackage{booktabs}` and nothing else."""
    align = "l" * table.labels + "r" * (len(table.columns) - table.labels)
    head, *rows = [" & ".join(map(_latex, row)) + r" \\" for row in (table.columns, *table.rows)]
    lines = [
        r"\begin{table}",
        r"\centering",
        rf"\caption{{{_latex(table.caption)}}}",
        rf"\label{{tab:{table.name}}}",
        rf"\begin{{tabular}}{{{align}}}",
        r"\toprule",
        head,
        r"\midrule",
        *rows,
        r"\bottomrule",
        r"\end{tabular}",
        r"\end{table}",
    ]
    return "\n".join([*lines, ""])


def write_tables(folder: Path, comparison: Comparison, contrasts: pd.DataFrame) -> list[Path]:
    """Write every number as CSV and Parquet, the short tables as LaTeX and Markdown; returns the files."""
    compared = write_table(folder, comparison_table(comparison), comparison.frame)
    return [*compared, *write_table(folder, contrast_table(contrasts), contrasts)]


def write_table(folder: Path, table: Table, frame: pd.DataFrame) -> list[Path]:
    """Write the numbers of a table as CSV and Parquet, its texts as LaTeX and Markdown; returns the files."""
    stem = folder / table.name
    frame.to_csv(stem.with_suffix(".csv"), index=False, lineterminator="\n")
    frame.to_parquet(stem.with_suffix(".parquet"), index=False)
    stem.with_suffix(".tex").write_text(to_latex(table), encoding="utf-8", newline="\n")
    stem.with_suffix(".md").write_text(to_markdown(table), encoding="utf-8", newline="\n")
    return [stem.with_suffix(suffix) for suffix in SUFFIXES]


def _latex(text: str) -> str:
    # A bracket that begins a row would be read as the option of the line break before it.
    escaped = "".join(_LATEX.get(letter, letter) for letter in text)
    return f"{{{escaped}}}" if escaped.startswith("[") else escaped


def _markdown(text: str) -> str:
    plain = " ".join(text.split())
    return "".join(f"\\{letter}" if letter in _MARKDOWN else letter for letter in plain)


def text_width(text: str) -> int:
    """Return the columns of a terminal that a line takes; wide letters take two."""
    return sum(2 if unicodedata.east_asian_width(letter) in "WF" else 1 for letter in text)
