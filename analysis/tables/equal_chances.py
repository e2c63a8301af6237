"""Tests whether mutually exclusive outcomes, such as the conventions of a crowd, are equally likely."""

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import numpy as np
import pandas as pd

from analysis.arrays import FloatArray
from analysis.signatures import discover
from analysis.stats.values import Group
from analysis.tables.comparison import Comparison
from analysis.tables.table import Table
from analysis.tables.texts import p_value, text_rows
from foundry import seeding

DRAWS = 20_000
_ROUNDING = 1e-9


def equal_chances(compared: Comparison) -> pd.DataFrame:
    """Return a row per group and family of `exclusive` measures, with the frequencies of its outcomes.

    Seeds are the units. Seeds without an outcome of the family are left out, and also groups without any outcome.

    - n: number of seeds with an outcome. outcomes: number of possible outcomes. most: the most frequent outcome (the
      first, if tied). share: its share of n. counts: observed outcomes, most frequent first.
    - chi_square: sum of (count - n / outcomes)^2 / (n / outcomes). p: from `uniform_p`, without correction.
    """
    rows = [
        _row(family, columns, group, compared)
        for family, columns in _families(compared)
        for group in compared.groups
        if all((column, group) in compared.estimates for column in columns)
    ]
    names = ["measure", *compared.group_columns, "n", "outcomes", "most", "share", "counts", "chi_square", "p"]
    return pd.DataFrame([row for row in rows if row["n"]], columns=names)


def equal_chances_table(frame: pd.DataFrame) -> Table:
    """Return the frequencies of outcomes as a readable table."""
    caption = (
        "Number of seeds with each outcome; each seed has exactly one. Pearson's chi-square tests whether all are "
        f"equally likely (p from {DRAWS:,} random draws, without correction)."
    )
    names = list(frame.columns[: frame.columns.get_loc("n")])
    rows = [
        (
            *(str(row[name]) for name in names),
            row["counts"],
            str(row["n"]),
            row["chi_square"],
            p_value(row["p"]),
        )
        for row in text_rows(frame, ("chi_square",))
    ]
    columns = (*names, "counts", "n", "chi-square", "p")
    return Table("equal_chances", caption, columns, tuple(rows), labels=len(names))


def _families(compared: Comparison) -> Iterator[tuple[str, list[str]]]:
    """Yield each set of measures that exclude each other, such as the shares of names: common name, and columns."""
    present = list(dict.fromkeys(measure for measure, _ in compared.estimates))
    for signature in discover():
        mine = [name for name in present if name.startswith(f"{signature.name}.")]
        for pattern in (name for name, measure in signature.measures.items() if measure.exclusive):
            start = f"{signature.name}.{pattern.removesuffix('*')}"
            columns = [
                name
                for name in mine
                if name.startswith(start) and not signature.is_readable_only(name.partition(".")[2])
            ]
            if columns:
                yield f"{signature.name}.{pattern}", columns


def _row(family: str, columns: list[str], group: Group, compared: Comparison) -> dict[str, Any]:
    counts = compared.values[group][columns].dropna().sum()
    start = family.removesuffix("*")
    came = (
        counts[counts > 0].sort_values(ascending=False, kind="stable").rename(lambda label: label.removeprefix(start))
    )
    n = round(float(counts.sum()))
    statistic, p = uniform_p(counts.to_numpy(dtype=np.float64))
    return {
        "measure": family,
        **dict(zip(compared.group_columns, group, strict=True)),
        "n": n,
        "outcomes": len(counts),
        "most": came.index[0] if n else "",
        "share": float(came.iloc[0]) / n if n else np.nan,
        "counts": ", ".join(f"{name} {count:g}" for name, count in came.items()),
        "chi_square": statistic,
        "p": p,
    }


def uniform_p(counts: FloatArray) -> tuple[float, float]:
    """Return Pearson's chi-square of counts against equal chances, and its p value.

    p is the share of samples with at least this chi-square, among `DRAWS` simulated samples of the same size and the
    counts themselves. The test keeps its level exactly for any number of runs.

    Source: Pearson 1900; Barnard 1963 and Hope 1968 for tests by draws.

    Args:
        counts: count of each outcome, (k,).
    """
    n, k = round(float(counts.sum())), len(counts)
    if not n:
        return np.nan, np.nan
    statistic = float(((counts - n / k) ** 2).sum() / (n / k))
    return statistic, float(1 + (_drawn_statistics(n, k) >= statistic - _ROUNDING).sum()) / (1 + DRAWS)


@lru_cache(maxsize=16)
def _drawn_statistics(n: int, k: int) -> FloatArray:
    """Return Pearson's chi-square of simulated samples of n runs with k outcomes, (DRAWS,)."""
    drawn = seeding.stream(0, "equal chances").multinomial(n, np.full(k, 1 / k), size=DRAWS)
    statistics: FloatArray = ((drawn - n / k) ** 2).sum(axis=1) / (n / k)
    return statistics
