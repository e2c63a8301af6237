"""Finds the value of a swept setting above which an outcome occurs in most runs."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from analysis.arrays import FloatArray
from analysis.prose import group_label, joined
from analysis.stats.intervals import Estimate
from analysis.stats.values import Group
from analysis.tables.comparison import Comparison
from analysis.tables.table import Table
from analysis.tables.texts import number, text_rows, with_interval

LEVEL = 0.5
"""An outcome prevails at a value of the setting if it occurs in more than this share of the runs."""
FEWEST_VALUES = 3
"""Minimum number of values of a setting that are needed to compute at which value an outcome begins to prevail."""


def thresholds(compared: Comparison) -> pd.DataFrame:
    """Return a row per outcome, swept setting and combination of the other settings.

    Outcomes are measures that are 1 or 0 in each run. A setting is a swept number with at least three values.

    - values: number of values of the setting. n: number of seeds for the value with the fewest seeds.
    - threshold: value at which the share of seeds exceeds one half, interpolated linearly between neighbours. Shares
      are first made non-decreasing in the setting by isotonic regression (Ayer et al. 1955). NaN if there is none, or
      if the interval of a value lies on the wrong side of one half.
    - low: greatest value with a 95 % interval below one half. high: least value with an interval above one half.
    - prevails: `from` (from the threshold on), `never`, `always`, or `some`: at some values, but not from a value on.
    """
    rows = [
        _row(measure, setting, others, points)
        for setting, at in _settings(compared).items()
        for measure, others, points in _lines(compared, setting, at)
    ]
    others = list(dict.fromkeys(name for row in rows for name in row["others"]))
    columns = ["measure", "setting", *others, "values", "n", "threshold", "low", "high", "prevails"]
    return pd.DataFrame([{**row, **row["others"]} for row in rows], columns=columns)


def thresholds_table(frame: pd.DataFrame) -> Table:
    """Return the thresholds as a readable table."""
    labels = list(frame.columns[: frame.columns.get_loc("values")])
    rows = [
        (*(str(row[name]) for name in labels), str(row["values"]), str(row["n"]), row["threshold"], row["prevails"])
        for row in text_rows(frame, (), {"threshold": ("low", "high")})
    ]
    caption = (
        "Value of a setting above which an outcome occurs in more than half of the seeds. In brackets: the nearest "
        "values at which the 95 % interval of this share lies entirely below or above one half."
    )
    return Table("thresholds", caption, (*labels, "values", "n", "threshold", "prevails"), tuple(rows), len(labels))


def sentences(frame: pd.DataFrame) -> list[str]:
    """Return a sentence for each threshold."""
    labels = list(frame.columns[2 : frame.columns.get_loc("values")])
    return [
        f"{row['measure']} of {group_label([str(row[name]) for name in labels])} {_sentence(row)} "
        f"({row['values']} values, at least {row['n']} seeds each)."
        for row in frame.to_dict("records")
    ]


def _sentence(row: Mapping[Any, Any]) -> str:
    if row["prevails"] == "some":
        return f"prevails at some values of {row['setting']}, but at no threshold does it begin to prevail for good"
    if row["prevails"] != "from":
        return f"{row['prevails']} prevails where {row['setting']} is varied"
    sure = with_interval(row["threshold"], row["low"], row["high"])
    open_ends = [name for name, end in (("lower", row["low"]), ("upper", row["high"])) if math.isnan(end)]
    weak = f"; no value is clearly beyond the {joined(open_ends)} end" if open_ends else ""
    return f"prevails from {row['setting']} = {number(row['threshold']) if open_ends else sure}{weak}"


def _settings(compared: Comparison) -> dict[str, int]:
    numbers = {}
    for at, name in enumerate(compared.group_columns):
        values = {group[at] for group in compared.groups if group not in compared.baselines}
        if len(values) >= FEWEST_VALUES and all(map(_is_number, values)):
            numbers[name] = at
    return numbers


def _is_number(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False


def _lines(
    compared: Comparison, setting: str, at: int
) -> Iterator[tuple[str, dict[str, str], list[tuple[float, Estimate]]]]:
    """Yield each outcome for each combination of the other settings, with the estimate at each value of `setting`."""
    names = [name for name in compared.group_columns if name != setting]
    for measure in dict.fromkeys(measure for measure, _ in compared.estimates):
        if not compared.describe(measure).outcome:
            continue
        points: dict[Group, list[tuple[float, Estimate]]] = {}
        for group in compared.groups:
            estimate = compared.estimates.get((measure, group))
            if estimate is not None and estimate.n and group not in compared.baselines:
                points.setdefault((*group[:at], *group[at + 1 :]), []).append((float(group[at]), estimate))
        if len({estimate.mean for line in points.values() for _, estimate in line}) < 2:
            continue
        for others, line in points.items():
            if len(line) >= FEWEST_VALUES:
                yield measure, dict(zip(names, others, strict=True)), sorted(line, key=lambda point: point[0])


def _row(
    measure: str, setting: str, others: Mapping[str, str], points: Sequence[tuple[float, Estimate]]
) -> dict[str, Any]:
    from scipy.optimize import isotonic_regression

    values = np.array([value for value, _ in points])
    shares = isotonic_regression(
        [estimate.mean for _, estimate in points], weights=[estimate.n for _, estimate in points]
    ).x
    below = [value for value, estimate in points if estimate.high < LEVEL]
    above = [value for value, estimate in points if estimate.low > LEVEL]
    at = passed(values, shares)
    if max(below, default=-math.inf) > at or min(above, default=math.inf) < at:
        at = math.nan  # the share surely falls again
    return {
        "measure": measure,
        "setting": setting,
        "others": others,
        "values": len(points),
        "n": min(estimate.n for _, estimate in points),
        "threshold": at,
        "low": max(below, default=math.nan),
        "high": min(above, default=math.nan),
        "prevails": _prevails(at, [estimate.mean > LEVEL for _, estimate in points]),
    }


def _prevails(threshold: float, at_values: Sequence[bool]) -> str:
    """Return where an outcome prevails; `at_values` says at which values it does, lowest value first."""
    if not math.isnan(threshold):
        return "from"
    return "always" if all(at_values) else "some" if any(at_values) else "never"


def passed(values: FloatArray, shares: FloatArray) -> float:
    """Return the value of the setting at which the shares (k,) begin to exceed LEVEL, by linear interpolation.

    The shares must rise with the values. NaN if all shares exceed LEVEL, or none.
    """
    if shares[0] > LEVEL or shares[-1] <= LEVEL:
        return math.nan
    above = int(np.argmax(shares > LEVEL))
    low, high = shares[above - 1], shares[above]
    return float(values[above - 1] + (LEVEL - low) / (high - low) * (values[above] - values[above - 1]))
