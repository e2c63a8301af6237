"""Writes the tables of an analysis as texts, and as files in CSV, Parquet, LaTeX and Markdown."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

from analysis.arrow import write_parquet
from analysis.prose import group_label
from analysis.signatures import discover
from analysis.stats.intervals import Estimate
from analysis.stats.plan import DECLARED, EXPLORATORY
from analysis.stats.values import Group
from analysis.tables.comparison import Comparison
from analysis.tables.latex import of_columns, split_by, to_latex
from analysis.tables.signature_table import ANY_PROMPT
from analysis.tables.table import Table
from foundry.texts import as_cell, one_line

_ROUNDING = 1e-12
_WHOLE = 1_000
"""Numbers from 1000 on are written without decimals."""
_MARKDOWN = "\\`*_{}[]<>|#~"


COMPARED = "Mean over seeds with its 95 % interval. n is given if some seeds have no value."
CONTRASTED = (
    "Difference between two groups (first minus second), paired by seed: mean with its 95 % interval, and p after "
    "correction for all tests by step-down max-T and Holm's method. A star marks a significant difference, a tilde a "
    "difference within the declared margin. g is Hedges' g of the differences. P(first > second) is the share of "
    "seeds in which the first group has the greater value."
)
"""Caption of a table of differences."""

NUMBERS = (".csv", ".parquet")
"""Suffixes of the files that hold the numbers of a table."""
SUFFIXES = (*NUMBERS, ".tex", ".md")
"""Suffixes of all files of a table."""


def shown_measures(comparison: Comparison) -> list[str]:
    """Return the headline measures that any group has, including cost."""
    present = list(dict.fromkeys(measure for measure, _ in comparison.estimates))
    return [column for signature in discover() for column in signature.headline_columns(present)]


def comparison_table(comparison: Comparison) -> Table:
    """Return a table with a row per headline measure and a column per group."""
    groups = comparison.groups
    seeds = {group: len(values) for group, values in comparison.values.items()}
    rows = [
        (measure, *(mean_cell(comparison.estimates.get((measure, group)), seeds[group]) for group in groups))
        for measure in shown_measures(comparison)
    ]
    names = (_baseline_label(group) if group in comparison.baselines else group_label(group) for group in groups)
    return Table("comparison", COMPARED, ("measure", *names), tuple(rows))


def _baseline_label(group: Group) -> str:
    return group_label([name for name in group if name != ANY_PROMPT]) + " (baseline)"


def contrast_table(contrasts: pd.DataFrame) -> Table:
    """Return a table of the declared differences; the untested differences from baselines follow."""
    return _contrast_table(CONTRASTED, _contrast_rows(contrasts))


def contrast_tables(contrasts: pd.DataFrame) -> list[Table]:
    """Return `contrast_table` as one table per measure, with the name of the measure as caption."""
    by_measure: dict[str, list[tuple[str, ...]]] = {}
    for row in _contrast_rows(contrasts):
        by_measure.setdefault(row[0], []).append(row)
    return [_contrast_table(measure, rows) for measure, rows in by_measure.items()]


def _contrast_rows(contrasts: pd.DataFrame) -> list[tuple[str, ...]]:
    family = contrasts["headline"].astype(bool)
    measures = set(contrasts.loc[family, "measure"])
    others = contrasts["baseline"].astype(bool) & contrasts["measure"].isin(measures)
    shown = pd.concat([contrasts[family], contrasts[others]])
    rows = text_rows_by_measure(shown, ("g_z", "superiority"), {"difference": ("low", "high")})
    return [_contrast_row(row) for row in rows]


def _contrast_table(caption: str, rows: Sequence[tuple[str, ...]]) -> Table:
    columns = ("pairs", "difference", "p (adjusted)", "g", "P(first > second)")
    names = ("measure", "first", "second", "context", "claim")
    return without_empty(Table("contrasts", caption, (*names, *columns), tuple(rows), labels=len(names)))


def without_empty(table: Table) -> Table:
    """Leave out each column of names (not numbers) that is empty in every row."""
    columns = [
        index
        for index in range(len(table.columns))
        if index >= table.labels or not table.rows or any(row[index] for row in table.rows)
    ]
    return of_columns(table, columns)


def _contrast_row(row: Mapping[Any, Any]) -> tuple[str, ...]:
    mark = ("*" if row["significant"] else "") + ("~" if row["equivalent"] else "")
    return (
        str(row["measure"]),
        str(row["level"]),
        str(row["reference"]),
        str(row["context"]),
        claim_of(row),
        str(row["n_pairs"]),
        row["difference"],
        p_value(row["p_adjusted"]) + mark if not math.isnan(row["p_adjusted"]) else str(row["test"]),
        row["g_z"],
        row["superiority"],
    )


def claim_of(row: Mapping[Any, Any]) -> str:
    """Return the claim of a row as text, such as `declared, look 2, alpha .04`."""
    if row["claim"] == EXPLORATORY:
        return EXPLORATORY + (f", look {row['look']}" if row["look"] > 1 else "")
    return (
        f"{DECLARED}, look {row['look']}, alpha {p_value(row['alpha'])}" if row["look"] else f"{DECLARED}, no look yet"
    )


def mean_cell(estimate: Estimate | None, seeds: int) -> str:
    """Return a mean with its interval, and with n if some of the `seeds` have no value; "" without an estimate."""
    if estimate is None:
        return ""
    return with_interval(estimate.mean, estimate.low, estimate.high) + (
        f" n={estimate.n}" if 0 < estimate.n < seeds else ""
    )


def mean_cells(estimates: Sequence[Estimate | None], seeds: Sequence[int]) -> list[str]:
    """Return means with intervals and equal decimals, and with n if some seeds have no value; None becomes ""."""
    known = [estimate for estimate in estimates if estimate]
    texts = iter(with_intervals([(estimate.mean, estimate.low, estimate.high) for estimate in known]))
    fewer = [
        f" n={estimate.n}" if estimate and 0 < estimate.n < asked else ""
        for estimate, asked in zip(estimates, seeds, strict=True)
    ]
    return ["" if estimate is None else next(texts) + count for estimate, count in zip(estimates, fewer, strict=True)]


def with_intervals(intervals: Sequence[tuple[float, float, float]]) -> list[str]:
    """Return numbers with their intervals (if not NaN), all with the same number of decimals."""
    texts = iter(alike([value for interval in intervals for value in interval]))
    rows = [(next(texts), next(texts), next(texts)) for _ in intervals]
    return [mean + ("" if low == "-" else f" [{low}, {high}]") for mean, low, high in rows]


def text_rows(
    frame: pd.DataFrame, numbers: Sequence[str], intervals: Mapping[str, tuple[str, str]] | None = None
) -> list[dict[Any, Any]]:
    """Return the rows of a frame with numbers as texts, with equal decimals in each column.

    Args:
        frame: the rows.
        numbers: names of columns with numbers.
        intervals: names of columns with means, each with the names of the columns with both ends of its interval.
    """
    return frame.assign(**_texts(frame, numbers, intervals or {})).to_dict("records")


def _texts(
    frame: pd.DataFrame, numbers: Sequence[str], intervals: Mapping[str, tuple[str, str]]
) -> dict[str, list[str]]:
    texts = {name: alike(frame[name].tolist()) for name in numbers}
    return texts | {
        name: with_intervals(list(zip(frame[name], frame[low], frame[high], strict=True)))
        for name, (low, high) in intervals.items()
    }


def alike(values: Sequence[float]) -> list[str]:
    """Return numbers as texts with equally many decimals: as many as give the largest number three digits.

    A value that would be rounded to 0 keeps its own digits.
    """
    greatest = max((abs(value) for value in values if abs(value) > _ROUNDING and math.isfinite(value)), default=1.0)
    whole = all(float(value).is_integer() for value in values if math.isfinite(value))
    decimals = 0 if whole else max(0, 2 - math.floor(math.log10(greatest)))

    def text(value: float) -> str:
        rounded = f"{value:.{decimals}f}"
        is_shown = math.isfinite(value) and (float(rounded) != 0 or abs(value) <= _ROUNDING)
        return rounded.removeprefix("-") if is_shown and float(rounded) == 0 else rounded if is_shown else number(value)

    return [text(value) for value in values]


def rounded(values: Sequence[float]) -> list[str]:
    """Return numbers with equal decimals, so that the largest number shows two digits; NaN becomes a hyphen."""
    finite = [abs(value) for value in values if abs(value) > _ROUNDING and math.isfinite(value)]
    # A share of 1 has the decimals of smaller shares.
    decimals = max(0, 1 - math.floor(math.log10(0.999 * max(finite, default=1.0))))
    texts = [f"{value:.{decimals}f}" for value in values]
    return [
        "-" if math.isnan(value) else text.removeprefix("-") if float(text) == 0 else text
        for value, text in zip(values, texts, strict=True)
    ]


def text_rows_by_measure(
    frame: pd.DataFrame, numbers: Sequence[str], intervals: Mapping[str, tuple[str, str]]
) -> list[dict[Any, Any]]:
    """Return the rows of a frame with numbers as texts; numbers of one measure have equally many decimals."""
    frame = frame.reset_index(drop=True)
    numbered = frame[["measure", *numbers, *(name for own, ends in intervals.items() for name in (own, *ends))]]
    texts = [
        pd.DataFrame(_texts(rows, numbers, intervals), index=rows.index, dtype=object)
        for _, rows in numbered.groupby("measure", sort=False)
    ]
    return frame.assign(**pd.concat(texts)).to_dict("records") if texts else []


def with_interval(mean: float, low: float, high: float) -> str:
    """Return a number with its interval, unless the interval is NaN."""
    return number(mean) + ("" if math.isnan(low) else f" [{number(low)}, {number(high)}]")


def number(value: float) -> str:
    """Return a number with three significant digits; NaN becomes a hyphen, and a rounding error becomes 0."""
    if math.isnan(value):
        return "-"
    if abs(value) >= _WHOLE:
        return f"{value:.0f}"
    return f"{value:.3g}" if abs(value) > _ROUNDING else "0"


def p_value(p: float) -> str:
    """Return a p value with three decimals, such as `.042` or `<.001`; NaN becomes a hyphen."""
    return "-" if math.isnan(p) else "<.001" if p < 0.001 else f"{p:.3f}".lstrip("0")


def to_markdown(table: Table) -> str:
    """Return the table as Markdown, with its caption below it."""
    rule = ["---" if index < table.labels else "---:" for index in range(len(table.columns))]
    rows = [[escaped(text) for text in row] for row in (table.columns, *table.rows)]
    lines = [f"| {' | '.join(row)} |" for row in (rows[0], rule, *rows[1:])]
    return "\n".join([*lines, "", escaped(table.caption), ""])


def write_tables(folder: Path, comparison: Comparison, contrasts: pd.DataFrame, filtered: str = "") -> list[Path]:
    """Write the numbers of groups and differences as CSV and Parquet, and short tables as LaTeX and Markdown."""
    compared = write_table(folder, comparison_table(comparison), comparison.frame, filtered)
    table = contrast_table(contrasts)
    return [*compared, *write_table(folder, table, contrasts, filtered, parts=split_by(table, "context"))]


def write_table(
    folder: Path, table: Table, frame: pd.DataFrame, filtered: str = "", parts: Sequence[Table] = ()
) -> list[Path]:
    """Write numbers as CSV and Parquet, and texts as LaTeX (in parts, see `to_latex`) and Markdown."""
    stem = folder / table.name
    write_numbers(stem, frame, filtered)
    if filtered:
        table, *parts = [
            replace(part, caption=f"{part.caption} Only a part of the runs: {filtered}.") for part in (table, *parts)
        ]
    stem.with_suffix(".tex").write_text(to_latex(table, parts), encoding="utf-8", newline="\n")
    stem.with_suffix(".md").write_text(to_markdown(table), encoding="utf-8", newline="\n")
    return [stem.with_suffix(suffix) for suffix in SUFFIXES]


def write_numbers(stem: Path, frame: pd.DataFrame, filtered: str = "") -> list[Path]:
    """Write the numbers of a table as CSV and Parquet; if runs are filtered, a column names the filter."""
    frame = frame.assign(filter=filtered) if filtered else frame
    files = [stem.with_suffix(suffix) for suffix in NUMBERS]
    spreadsheet_frame(frame).to_csv(files[0], index=False, lineterminator="\n")
    write_parquet(frame, files[1])
    return files


def spreadsheet_frame(frame: pd.DataFrame) -> pd.DataFrame:
    """Change the texts that a spreadsheet would run as formulas; see `foundry.texts.as_cell`."""
    safe = frame.rename(columns=as_cell)
    for name in safe.select_dtypes(exclude=["number", "bool"]):
        cells = {value: as_cell(value) for value in safe[name].unique() if isinstance(value, str)}
        if any(value != cell for value, cell in cells.items()):
            safe[name] = safe[name].map(lambda value, cells=cells: cells[value] if isinstance(value, str) else value)
    return safe


def escaped(text: str) -> str:
    """Return a text as one line of Markdown, with its special characters escaped."""
    plain = one_line(text)
    return "".join(f"\\{letter}" if letter in _MARKDOWN else letter for letter in plain)


def remove_table(stem: Path, suffixes: Sequence[str] = SUFFIXES) -> None:
    """Remove the files of a table that has become empty."""
    for suffix in suffixes:
        stem.with_suffix(suffix).unlink(missing_ok=True)


def write_summary(folder: Path, sentences: Sequence[str], notes: Sequence[str]) -> Path:
    """Write findings and notes as two lists in Markdown, and return the file."""
    path = folder / "summary.md"
    parts = [(head, lines) for head, lines in (("## Findings", sentences), ("## Notes", notes)) if lines]
    texts = ["\n".join([head, "", *(f"- {escaped(line)}" for line in lines), ""]) for head, lines in parts]
    path.write_text("\n".join(texts), encoding="utf-8", newline="\n")
    return path
