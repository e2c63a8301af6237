"""Converts the comparisons of a probe to the table of contrasts that the analysis of sweeps reads.

A row compares a distance between choices (`mean_level`) with the distance expected by chance (`mean_reference`). The
column `difference` is the distance minus the distance by chance, with the interval and the one-sided test of the probe.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from analysis.measure import Measure
from analysis.paper.sentence import Sides
from analysis.probes.choices import NONE, PROBABILITIES
from analysis.probes.probe_declaring import Family
from analysis.stats.contrasts import ALPHA, COLUMNS
from analysis.stats.factors import MODEL
from analysis.stats.intervals import FEWEST_FOR_CLAIMS, SIGN_FLIP
from analysis.stats.plan import DECLARED, EXPLORATORY
from analysis.stats.testing import NOT_TESTED
from foundry.records import UNREAD
from foundry.texts import counted

Row = Mapping[Any, Any]
EDIT, FORMAT = "edit", "format"
"""The factors that a probe compares besides the model: edits of the observation and formats of the prompt."""
_BY_LEAVES = {
    "invariance": "decides differently, though it should not,",
    "cause": "decides differently",
    "equivariance": "misses its expected decision more often",
}
DISTANCES = "Each distance between choices in the same moments, 0 to 1, is compared with its floor by chance."
CAPTION = (
    "Distances between the choices in the same moments, minus the floor (the distance by chance): mean over seeds "
    "with its 90 % interval, and p of one-sided tests after Holm's correction (* significant). The last columns are "
    "Hedges' g, and the share of seeds above the floor."
)


def contrasts_of(frames: Mapping[str, pd.DataFrame], declared: Family, *, planned: bool, known: str) -> pd.DataFrame:
    """Return the table of contrasts of a probe: between models, between an edit and no edit, and between formats.

    Args:
        frames: the tables `agreement`, `edits`, `formats` and `moments` of the probe.
        declared: declared models and edits.
        planned: whether they were declared before the runs.
        known: text that says how much of the runs was known before the declaration.
    """
    families = {name: int(frames[name]["p_holm"].notna().sum()) for name in ("agreement", "edits", "formats")}
    if declared.is_given:
        families |= dict.fromkeys(("agreement", "edits"), families["agreement"] + families["edits"])
    once = _repeats(frames["moments"]) == 1 and not (frames["moments"]["by"] == PROBABILITIES).any()
    rows = [
        _row(row, families[name], once=once) | named(row)
        for name in families
        for row in _records(frames[name][declared.rows(frames[name])])
    ]
    claim = {"claim": DECLARED if planned else EXPLORATORY, "look": int(planned), "note": known}
    frame = pd.DataFrame([row | ({} if row["factor"] == FORMAT else claim) for row in rows], columns=list(COLUMNS))
    return frame.sort_values("p_adjusted", kind="stable", ignore_index=True)


def sides_of(frames: Mapping[str, pd.DataFrame]) -> Sides:
    """Return facts for sentences about differences: words for each distance, and shares of unreadable answers."""
    rows = [row for name in ("agreement", "edits", "formats") for row in _records(frames[name])]
    words = {named(row)["measure"]: Measure("distance beyond chance", -1.0, 1.0, says=_says(row)) for row in rows}
    shares = unread_shares(frames["moments"])
    unread = {side: share for (model, edit, written), share in shares.items() for side in _asked(model, edit, written)}
    return Sides(unread, {}, frozenset(), {}, words)


def named(row: Row) -> dict[str, str]:
    """Return the measure of a row of `agreement`, `edits` or `formats`, and the two models or prompts that it compares.

    The keys are columns of the table of contrasts.
    """
    if "first" in row:
        measure = f"distance of {row['first']} and {row['second']}"
        return {"measure": measure, "factor": MODEL, "level": row["first"], "reference": row["second"], "context": ""}
    if "edit" in row:
        own = {"measure": f"change under {row['edit']}", "factor": EDIT, "level": row["edit"], "reference": NONE}
    else:
        ends = {"level": row["greatest_format"], "reference": row["least_format"]}
        own = {"measure": f"spread of {row['choice']} ({row['kind']})", "factor": FORMAT, **ends}
    return own | {"context": f"{MODEL}={row['model']}"}


def unread_of(moments: pd.DataFrame) -> pd.DataFrame:
    """Return the number of answers and of unreadable answers, by model, edit and format."""
    unread = moments["count"].where(moments["choice"] == UNREAD, 0)
    by = [moments[name] for name in ("model", "edit", "format")]
    return pd.DataFrame({"answers": moments["count"], "unread": unread}).groupby(by, sort=False).sum()


def unread_shares(moments: pd.DataFrame) -> dict[tuple[str, str, str], float]:
    """Return the share of unreadable answers, by model, edit and format."""
    sums = unread_of(moments)
    return dict(zip(sums.index, sums["unread"] / sums["answers"], strict=True))


def _records(frame: pd.DataFrame) -> list[dict[Any, Any]]:
    return frame.to_dict("records")


def _says(row: Row) -> str:
    if "choice" in row:
        return f"chooses {row['choice']} more often"
    return _BY_LEAVES[row["leaves"]] if "edit" in row else "decides differently"


def _asked(model: str, edit: str, written: str) -> Iterator[tuple[str, str, str]]:
    """Yield the factor, level and context of each contrast that compares these answers with others."""
    if edit == written == NONE:
        yield MODEL, model, ""
    if written == NONE:
        yield EDIT, edit, f"{MODEL}={model}"
    if edit == NONE:
        yield FORMAT, written, f"{MODEL}={model}"


def _row(row: Row, family: int, *, once: bool) -> dict[str, Any]:
    few = row["seeds"] < FEWEST_FOR_CLAIMS
    return {
        **dict.fromkeys(COLUMNS, np.nan),
        "signature": "probe",
        "headline": True,
        "readable_only": False,
        "baseline": False,
        "n_pairs": row["seeds"],
        "n_missing": 0,
        "n_undefined": 0,
        "mean_level": row["distance"] if "distance" in row else row["spread"],
        "mean_reference": row["floor"],
        "difference": row["excess"],
        "low": row["excess_low"],
        "high": row["excess_high"],
        "interval": SIGN_FLIP,
        "test": f"{NOT_TESTED}{f'n < {FEWEST_FOR_CLAIMS}' if row['seeds'] else 'no pair'}" if few else SIGN_FLIP,
        "p": row["p"],
        "claim": EXPLORATORY,
        "look": 0,
        "alpha": ALPHA,
        "p_adjusted": row["p_holm"],
        "family": family,
        "pairs": family,
        "significant": row["p_holm"] <= ALPHA,
        "g_z": row["g_z"],
        "superiority": row["superiority"],
        "equivalent": False,
        "out_of_reach": _out_of_reach(row, family, once=once),
        "note": "",
    }


def _out_of_reach(row: Row, family: int, *, once: bool) -> str:
    """Return the reason why a row could not have been significant, or an empty text if it could."""
    if once:
        return "each moment was asked once"
    if row["seeds"] >= FEWEST_FOR_CLAIMS and family * 0.5 ** row["seeds"] > ALPHA and not row["p_holm"] <= ALPHA:
        return (
            f"with {row['seeds']} seeds, no p value can be as low as {ALPHA:g} after correction for "
            f"{counted(family, 'test')}"
        )
    return ""


def _repeats(moments: pd.DataFrame) -> float:
    """Return the largest number of times that one model was asked in one moment."""
    keys = [name for name in moments.columns if name not in ("choice", "count", "share", "by")]
    return float(moments.groupby(keys, dropna=False)["count"].sum().max())
