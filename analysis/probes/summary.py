"""What was found in a probe, in at most six sentences that hold: of declared rows alone, each with what weakens it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from analysis.paper.sentence import DIFFERENT, LEVEL, NOTHING, SILENT, equals_p
from analysis.paper.summary import EXPLORES, MOST, fitted, nothing_said
from analysis.probes.declaring import Family
from analysis.prose import joined, percent
from analysis.stats.contrasts import ALPHA
from analysis.stats.intervals import ENOUGH_FOR_CLAIMS, FEWEST_FOR_CLAIMS
from analysis.tables.texts import number, with_interval
from foundry.records import UNREAD

Row = Mapping[Any, Any]
_DIFFERENT = {
    "invariance": "{edit} changes what {model} chooses, which it should not",
    "cause": "{edit} changes what {model} chooses, as what is taken away may be a cause of it",
    "equivariance": "Under {edit} {model} does not choose what it should",
}
_NOTHING = {
    "invariance": "No change of what {model} chooses was found under {edit}",
    "cause": "No change of what {model} chooses was found under {edit}, which takes a possible cause away",
    "equivariance": "No error of {model} was found under {edit}",
}


def summary_of(frames: Mapping[str, pd.DataFrame], declared: Family) -> tuple[str, ...]:
    """Return what was found, a sentence each.

    Args:
        frames: the tables of the probe by name: `agreement`, `edits`, `moments`, `formats`, `steepness`.
        declared: the models and edits that were declared; all other rows are not said.
    """
    rows = [row for name in ("agreement", "edits") for row in _declared(frames[name], declared)]
    if not rows:
        return (_alone(frames),)
    asked_once = bool(_answers(frames["moments"]) == 1)
    family = {name: int(frames[name]["p_holm"].notna().sum()) for name in ("agreement", "edits")}
    rows = [{**row, "family": sum(family.values()) if declared.is_given else family[_table(row)]} for row in rows]
    found = [{**row, "why": _why_silent(row, asked_once)} for row in rows]
    found.sort(key=lambda row: ((DIFFERENT, NOTHING, SILENT).index(_kind(row)), row["p_holm"]))
    sums = unread_of(frames["moments"])
    unread = dict(zip(sums.index, sums["unread"] / sums["answers"], strict=True))
    told = fitted(
        found,
        _kind,
        lambda row: _sentence(row, unread),
        _silent([row for row in found if row["why"]]),
        most=MOST - 1,
        where="agreement.md and edits.md",
    )
    return (EXPLORES, *told)


def unread_of(moments: pd.DataFrame) -> pd.DataFrame:
    """Return how many `answers` each model gave, and how many `unread` ones, in which no decision could be read."""
    unread = moments["count"].where(moments["choice"] == UNREAD, 0)
    return pd.DataFrame({"answers": moments["count"], "unread": unread}).groupby(moments["model"], sort=False).sum()


def _declared(frame: pd.DataFrame, declared: Family) -> Sequence[Row]:
    return frame[declared.rows(frame)].to_dict("records")


def _alone(frames: Mapping[str, pd.DataFrame]) -> str:
    others = [name for name in ("formats", "steepness") if len(frames[name])]
    if others:
        return f"Neither models nor edits are compared: what was found is in {joined(f'{name}.md' for name in others)}."
    return "Nothing is compared: one model was asked, and nothing was edited."


def _answers(moments: pd.DataFrame) -> float:
    """Return how often each moment was put to a model at most."""
    keys = [name for name in moments.columns if name not in ("choice", "count", "share")]
    return float(moments.groupby(keys, dropna=False)["count"].sum().max())


def _table(row: Row) -> str:
    return "agreement" if "first" in row else "edits"


def _kind(row: Row) -> str:
    if row["why"]:
        return SILENT
    return DIFFERENT if row["p_holm"] <= ALPHA else NOTHING


def _why_silent(row: Row, asked_once: bool) -> str:
    """Return why nothing can be said of a row; "" where something can."""
    if not row["moments"]:
        return "there is no moment to compare"
    if asked_once:
        return "each moment was asked once"
    if row["seeds"] < FEWEST_FOR_CLAIMS:
        return f"fewer than {FEWEST_FOR_CLAIMS} seeds only describe these runs"
    if row["family"] * 0.5 ** row["seeds"] > ALPHA and not row["p_holm"] <= ALPHA:
        return f"no p can reach {LEVEL} with {row['seeds']} seeds in {row['family']} tests"
    return ""


def _sentence(row: Row, unread: Mapping[str, float]) -> str:
    figures = (
        f"total variation {number(row['distance'])}, by chance {number(row['floor'])}, excess "
        f"{with_interval(row['excess'], row['excess_low'], row['excess_high'])}, {row['moments']} moments of "
        f"{row['seeds']} seeds, p{equals_p(row['p_holm'])} "
        f"{'after correction in ' + str(row['family']) if row['family'] > 1 else 'in the only test'} (level {LEVEL})"
    )
    models = [row["model"]] if "model" in row else [row["first"], row["second"]]
    weak = ["its interval holds 0"] if _kind(row) == DIFFERENT and row["excess_low"] <= 0 else []
    few = _kind(row) == NOTHING and row["seeds"] < ENOUGH_FOR_CLAIMS
    weak += [f"fewer than {ENOUGH_FOR_CLAIMS} seeds find large differences alone"] if few else []
    weak += [f"{percent(unread[one])} of the answers of {one} could not be read" for one in models if unread.get(one)]
    return "; ".join([f"{_said(row)}: {figures}", *weak]) + "."


def _said(row: Row) -> str:
    if "edit" in row:
        return (_DIFFERENT if _kind(row) == DIFFERENT else _NOTHING)[row["leaves"]].format_map(dict(row))
    if _kind(row) == DIFFERENT:
        return f"{row['first']} and {row['second']} choose differently beyond chance in the same moments"
    return f"No difference beyond chance was found between what {row['first']} and {row['second']} choose"


def _silent(rows: list[Row]) -> list[str]:
    """Return the one sentence on what nothing can be said of; none where there is no such row."""
    return [nothing_said([row["why"] for row in rows])] if rows else []
