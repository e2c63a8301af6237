"""What was found in a probe, in at most six sentences that hold: of declared rows alone, each with what weakens it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import pandas as pd

from analysis.paper.sentence import DIFFERENT, LEVEL, NOTHING, SILENT, equals_p
from analysis.paper.summary import EXPLORES, nothing_said
from analysis.probes.choices import NONE
from analysis.probes.probe_declaring import Family
from analysis.prose import joined, percent
from analysis.stats.contrasts import ALPHA
from analysis.stats.intervals import ENOUGH_FOR_CLAIMS, FEWEST_FOR_CLAIMS
from analysis.tables.texts import number, with_interval
from foundry.records import UNREAD
from foundry.texts import counted

Row = Mapping[Any, Any]
MOST = 6
"""Sentences."""
_UNREAD_TOLD = 2
"""Formats whose unread answers the summary tells, those with the most."""
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


def summary_of(
    frames: Mapping[str, pd.DataFrame], declared: Family, filtered: str = "", *, planned: bool = False, known: str = ""
) -> tuple[str, ...]:
    """Return what was found, a sentence each.

    Args:
        frames: the tables of the probe by name: `agreement`, `edits`, `moments`, `formats`, `steepness`.
        declared: the models and edits that were declared; all other rows are not said.
        filtered: which answers it is of, where it is not of all.
        planned: whether they were declared before the runs.
        known: what was known of the runs before that, in words; "" where nothing was.
    """
    lead = [] if planned else [EXPLORES]
    part = [f"This is of a part of the answers: {filtered}."] if filtered else []
    rows = [row for name in ("agreement", "edits") for row in _declared(frames[name], declared)]
    unread = unread_shares(frames["moments"])
    formats = _of_formats(frames["formats"], declared, unread)
    if not rows:
        return (*part, *lead, *formats) if formats else (*part, _alone(frames))
    asked_once = bool(_answers(frames["moments"]) == 1)
    family = {name: int(frames[name]["p_holm"].notna().sum()) for name in ("agreement", "edits")}
    rows = [{**row, "family": sum(family.values()) if declared.is_given else family[_table(row)]} for row in rows]
    found = [{**row, "why": _why_silent(row, asked_once)} for row in rows]
    found.sort(key=lambda row: ((DIFFERENT, NOTHING, SILENT).index(_kind(row)), row["p_holm"]))
    told = _fitted(
        found,
        _kind,
        lambda row: _sentence(row, unread, known),
        _silent([row for row in found if row["why"]]),
        most=MOST - len(lead) - len(part) - len(formats),
        where="agreement.md and edits.md",
    )
    return (*part, *lead, *told, *formats)


def unread_of(moments: pd.DataFrame) -> pd.DataFrame:
    """Return how many `answers` each model gave by edit and format, and in how many no decision could be read."""
    unread = moments["count"].where(moments["choice"] == UNREAD, 0)
    by = [moments[name] for name in ("model", "edit", "format")]
    return pd.DataFrame({"answers": moments["count"], "unread": unread}).groupby(by, sort=False).sum()


def unread_shares(moments: pd.DataFrame) -> dict[tuple[str, str, str], float]:
    """Return the share of answers in which no decision could be read, by model, edit and format."""
    sums = unread_of(moments)
    return dict(zip(sums.index, sums["unread"] / sums["answers"], strict=True))


def _declared(frame: pd.DataFrame, declared: Family) -> Sequence[Row]:
    return frame[declared.rows(frame)].to_dict("records")


def _alone(frames: Mapping[str, pd.DataFrame]) -> str:
    if len(frames["steepness"]):
        return "Neither models nor edits are compared: what was found is in steepness.md."
    return "Nothing is compared: one model was asked, and nothing was edited."


def _of_formats(frame: pd.DataFrame, declared: Family, unread: Mapping[tuple[str, str, str], float]) -> list[str]:
    """Return the one sentence on formats; none where the prompt was written in one format alone."""
    if frame.empty:
        return []
    rows = frame[declared.choices(frame) & (frame["choice"] != UNREAD)].sort_values("p_holm", kind="stable")
    tested = int(frame["p_holm"].notna().sum())
    different = rows[rows["p_holm"] <= ALPHA].to_dict("records")
    if different:
        said = _spread(different[0], tested)
        others = [f"{counted(len(different) - 1, 'further choice')} in formats.md"] if len(different) > 1 else []
    elif tested:
        said, others = f"No choice depends on the format of the prompt beyond chance in {counted(tested, 'test')}", []
    else:
        said, others = "Nothing can be said of formats, since no share of a choice could be tested (formats.md)", []
    models = set(rows["model"])
    lost = {key: share for key, share in unread.items() if share and key[0] in models and key[1] == NONE}
    worst = sorted(lost, key=lambda key: -lost[key])
    told = [f"{percent(lost[key])} of the answers of {key[0]} in format {key[2]} could not be read" for key in worst]
    more = [f"some answers in {counted(len(told) - _UNREAD_TOLD, 'further format')} neither"]
    return ["; ".join([said, *others, *told[:_UNREAD_TOLD], *(more if len(told) > _UNREAD_TOLD else [])]) + "."]


def _spread(row: Row, tested: int) -> str:
    """Return how far the share of one choice spreads over formats."""
    family = f"after correction in {tested}" if tested > 1 else "in the only test"
    return (
        f"The format of the prompt changes how often {row['model']} chooses {row['choice']} ({row['kind']}): "
        f"{number(row['least'])} in format {row['least_format']}, {number(row['greatest'])} in "
        f"{row['greatest_format']}, excess {with_interval(row['excess'], row['excess_low'], row['excess_high'])}, "
        f"{row['moments']} moments of {row['seeds']} seeds, p{equals_p(row['p_holm'])} {family} (level {LEVEL})"
    )


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


def _sentence(row: Row, unread: Mapping[tuple[str, str, str], float], known: str) -> str:
    figures = (
        f"total variation {number(row['distance'])}, by chance {number(row['floor'])}, excess "
        f"{with_interval(row['excess'], row['excess_low'], row['excess_high'])}, {row['moments']} moments of "
        f"{row['seeds']} seeds, p{equals_p(row['p_holm'])} "
        f"{'after correction in ' + str(row['family']) if row['family'] > 1 else 'in the only test'} (level {LEVEL})"
    )
    few = _kind(row) == NOTHING and row["seeds"] < ENOUGH_FOR_CLAIMS
    weak = [f"fewer than {ENOUGH_FOR_CLAIMS} seeds find large differences alone"] if few else []
    weak += [
        f"{percent(share)} of the answers of {model}{'' if edit == NONE else f' under {edit}'} could not be read"
        for model, edit in _asked(row)
        if (share := unread.get((model, edit, NONE)))
    ]
    return "; ".join([f"{_said(row)}: {figures}", *filter(None, [known]), *weak]) + "."


def _asked(row: Row) -> list[tuple[str, str]]:
    """Return the models and edits whose answers a row compares, with the prompt as it is written."""
    if "edit" in row:
        return [(row["model"], NONE), (row["model"], row["edit"])]
    return [(row["first"], NONE), (row["second"], NONE)]


def _said(row: Row) -> str:
    if "edit" in row:
        return (_DIFFERENT if _kind(row) == DIFFERENT else _NOTHING)[row["leaves"]].format_map(dict(row))
    if _kind(row) == DIFFERENT:
        return f"{row['first']} and {row['second']} choose differently beyond chance in the same moments"
    return f"No difference beyond chance was found between what {row['first']} and {row['second']} choose"


def _silent(rows: list[Row]) -> list[str]:
    """Return the one sentence on what nothing can be said of; none where there is no such row."""
    return [nothing_said([row["why"] for row in rows])] if rows else []


def _fitted(
    rows: Sequence[Row],
    kind: Callable[[Row], str],
    told: Callable[[Row], str],
    silent: Sequence[str],
    *,
    most: int,
    where: str,
) -> list[str]:
    """Return as many sentences as there is room for; the last one counts what is left out.

    Args:
        rows: sorted by their kinds, those of which nothing can be said last.
        kind: returns the kind of a row.
        told: returns the sentence on a row.
        silent: what is said of those of which nothing can be said.
        most: how many sentences there may be.
        where: the tables in which the others are.
    """
    tested = [row for row in rows if kind(row) != SILENT]
    if len(tested) + len(silent) <= most:
        return [*map(told, tested), *silent]
    shown = tested[: most - 1]
    kinds = Counter(map(kind, rows[len(shown) :]))
    counts = joined(f"{count} {name}" for name, count in kinds.items())
    return [*map(told, shown), f"{kinds.total()} further comparisons are in {where}: {counts}."]
