"""Differences between groups of runs, paired by seed: size, interval, test, and whether the same is shown."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from analysis.stats.family import are_apart, is_denominator, primary_measures, unknown_measure
from analysis.stats.intervals import (
    FEWEST_FOR_CLAIMS,
    NO_VARIATION,
    Estimates,
    by_count,
    varies,
)
from analysis.stats.multiplicity import benjamini_hochberg, holm
from analysis.stats.paired import equivalence_p, hedges_g_z, mcnemar_p, superiority
from analysis.stats.pairing import Paired, bounds, mean_where, pair_up, row_frame
from analysis.stats.sign_flip import least_p, sign_flip_p
from analysis.stats.values import BoolArray, SeedValues, seed_values
from analysis.tables.groups import swept_columns
from analysis.tables.signature_table import SignatureTable
from foundry.errors import InputError

ALPHA = 0.05
SIGN_FLIP, MCNEMAR = "sign-flip", "mcnemar"
_NOT_TESTED = "not tested: "
_NO_PAIR = _NOT_TESTED + "no pair"
_FEW_PAIRS = f"{_NOT_TESTED}n < {FEWEST_FOR_CLAIMS}"
_FLAT = _NOT_TESTED + NO_VARIATION
_BASELINE = _NOT_TESTED + "baseline"


def contrasts(
    table: SignatureTable,
    groups: pd.DataFrame | None = None,
    *,
    family: Sequence[str] | None = None,
    margins: Mapping[str, float] | None = None,
    alpha: float = ALPHA,
    repeating: Mapping[str, str] | None = None,
) -> pd.DataFrame:
    """Return every difference between two groups that differ in one factor alone, one row per measure and pair.

    `docs/statistics.md` says what each column means.

    Args:
        table: the runs.
        groups: the columns that tell groups apart, one row per run; by default what was swept.
        family: measures of the declared family of tests; by default the first headline measure of each signature.
        margins: by measure, the difference below which groups count as the same; declared before the runs.
        alpha: level of the tests.
        repeating: by model whose server does not repeat itself, how far it does; said of the rows that its runs are in.

    Raises:
        InputError: a measure of the family or of a margin does not exist, or a margin is not positive.
    """
    values = seed_values(table, groups)
    declared = primary_measures(values.measures) if family is None else _known(family, values.measures)
    servers = _servers(values, table, groups, repeating or {})
    blocks = [_row_by_row(values, paired, declared, servers) for paired in pair_up(values)]
    frame = pd.concat([rows for rows, _ in blocks], ignore_index=True)
    found = Estimates.joined([estimated for _, estimated in blocks])
    frame = frame.assign(**_over_families(frame, alpha))
    frame = frame.assign(**_equivalence(frame, found, _checked(margins or {}, values.measures), alpha))
    return frame.assign(note=_notes(frame, found, alpha))[list(COLUMNS)]


COLUMNS = (
    "measure", "signature", "headline", "readable_only", "baseline", "factor", "level", "reference", "context",
    "n_pairs", "n_missing", "n_undefined", "mean_level", "mean_reference", "difference", "low", "high", "interval",
    "test", "p", "p_holm", "family", "significant", "p_bh", "g_z", "superiority", "bound_low", "bound_high",
    "margin", "p_equivalence", "p_equivalence_holm", "equivalent", "note",
)  # fmt: skip
"""The columns of the table of contrasts, in their order."""


def _known(names: Sequence[str], measures: Sequence[str]) -> tuple[str, ...]:
    for name in names:
        if name not in measures:
            raise unknown_measure(name, measures)
    return tuple(names)


def _checked(margins: Mapping[str, float], measures: Sequence[str]) -> Mapping[str, float]:
    _known(list(margins), measures)
    for name, margin in margins.items():
        if not 0 < margin < math.inf:
            raise InputError(f"The margin of {name} is {margin:g}: give one above 0, in the unit of the measure.")
    return margins


def _servers(
    values: SeedValues, table: SignatureTable, groups: pd.DataFrame | None, repeating: Mapping[str, str]
) -> list[str]:
    """Return what is said of the server of each group (G); "" where it repeats itself, or nobody knows."""
    keys = (swept_columns(table) if groups is None else groups).astype(str).itertuples(index=False, name=None)
    models = dict(zip(keys, table.frame["model"].astype(str), strict=True))
    return [repeating.get(models[group], "") for group in values.groups]


def _row_by_row(
    values: SeedValues, paired: Paired, declared: Sequence[str], servers: Sequence[str]
) -> tuple[pd.DataFrame, Estimates]:
    """Return the columns of some rows that no other row changes, and the estimates behind them."""
    found = paired.estimates()
    frame = row_frame(values, paired, declared).assign(**_sizes(paired, found))
    frame = frame.assign(**_tests(paired, found, frame["baseline"].to_numpy(dtype=bool)))
    said = [dict.fromkeys((servers[pair.level], servers[pair.reference])) for pair in paired.pair]
    frame = frame.assign(servers=["; ".join(filter(None, both)) for both in said])
    return frame.assign(**_effects(paired, found), **_extremes(paired)), found


def _sizes(paired: Paired, found: Estimates) -> dict[str, Any]:
    """Return the columns of counts, means and the interval of the difference."""
    both = ~np.isnan(paired.difference)
    return {
        "n_pairs": found.n,
        "n_missing": paired.missing.sum(axis=1),
        "n_undefined": paired.undefined.sum(axis=1),
        "mean_level": mean_where(paired.level, both),
        "mean_reference": mean_where(paired.reference, both),
        "difference": found.mean,
        "low": found.low,
        "high": found.high,
        "interval": found.interval,
    }


def _tests(paired: Paired, found: Estimates, baseline: BoolArray) -> dict[str, Any]:
    """Return the columns `test` and `p`."""
    test = np.full(len(baseline), _NO_PAIR, dtype=object)
    p = np.full(len(baseline), np.nan)
    for rows, kept in by_count(paired.difference):
        test[rows] = _FEW_PAIRS
        if kept.shape[1] >= FEWEST_FOR_CLAIMS:
            # Success of one against failure of the other in every seed varies no more than equal outcomes do.
            mcnemar = paired.outcome[rows] & kept.any(axis=1)
            test[rows] = np.where(mcnemar, MCNEMAR, np.where(varies(kept), SIGN_FLIP, _FLAT))
            for name, p_of in ((MCNEMAR, mcnemar_p), (SIGN_FLIP, sign_flip_p)):
                own = test[rows] == name
                p[rows[own]] = p_of(kept[own])
    return {"test": np.where(baseline, _BASELINE, test), "p": np.where(baseline, np.nan, p)}


def _over_families(frame: pd.DataFrame, alpha: float) -> dict[str, Any]:
    """Return the columns that take all tests of one factor together."""
    p = frame["p"].to_numpy(dtype=np.float64)
    explored = ~frame["readable_only"].to_numpy(dtype=bool)
    explored &= ~np.array([is_denominator(name) for name in frame["measure"]], dtype=bool)
    headline = frame["headline"].to_numpy(dtype=bool)
    apart = are_apart(frame["measure"].tolist())
    adjusted, rates = np.full(len(p), np.nan), np.full(len(p), np.nan)
    size = np.zeros(len(p), dtype=np.int64)
    for factor in frame["factor"].unique():
        own = (frame["factor"] == factor).to_numpy()
        adjusted[own & headline] = holm(p[own & headline])
        for some in (~apart, apart):
            rates[own & explored & some] = benjamini_hochberg(p[own & explored & some])
        size[own & headline] = np.count_nonzero(~np.isnan(p[own & headline]))
    return {"p_holm": adjusted, "family": size, "significant": adjusted <= alpha, "p_bh": rates}


def _effects(paired: Paired, found: Estimates) -> dict[str, Any]:
    g_z, above = np.full(len(found.n), np.nan), np.full(len(found.n), np.nan)
    for rows, kept in by_count(paired.difference):
        g_z[rows] = hedges_g_z(found.mean[rows], found.sd[rows], kept.shape[1])
        above[rows] = superiority(kept)
    return {"g_z": g_z, "superiority": above}


def _extremes(paired: Paired) -> dict[str, Any]:
    low, high = bounds(paired)
    return {"bound_low": low, "bound_high": high}


def _equivalence(frame: pd.DataFrame, found: Estimates, margins: Mapping[str, float], alpha: float) -> dict[str, Any]:
    """Return the columns of the equivalence tests; corrected over all those of one factor."""
    margin = np.array([margins.get(name, np.nan) for name in frame["measure"]], dtype=np.float64)
    margin[frame["baseline"].to_numpy(dtype=bool)] = np.nan
    p = np.full(len(margin), np.nan)
    for n in np.unique(found.n[found.n >= FEWEST_FOR_CLAIMS]):
        rows = found.n == n
        p[rows] = equivalence_p(found.mean[rows], found.sd[rows], margin[rows], int(n))
    adjusted = np.full(len(p), np.nan)
    for factor in frame["factor"].unique():
        own = (frame["factor"] == factor).to_numpy()
        adjusted[own] = holm(p[own])
    return {"margin": margin, "p_equivalence": p, "p_equivalence_holm": adjusted, "equivalent": adjusted <= alpha}


def _notes(frame: pd.DataFrame, found: Estimates, alpha: float) -> list[str]:
    """Return what keeps each row from being a claim, or weakens it."""
    reachable = {int(n): least_p(int(n)) for n in np.unique(found.n) if n >= FEWEST_FOR_CLAIMS}
    columns = (frame[name] for name in ("n_missing", "n_undefined", "family", "servers"))
    parts = zip(found.note, found.n, *columns, frame["p"].notna(), strict=True)
    return [
        "; ".join(
            part
            for part in (
                note,
                f"missing in {missing} of {n + missing + undefined} seeds" if missing else "",
                f"undefined in {undefined} of {n + missing + undefined} seeds" if undefined else "",
                f"no p can reach {alpha:g} with {n} pairs among {family} tests"
                if tested and reachable[n] * family > alpha
                else "",
                servers,
            )
            if part
        )
        for note, n, missing, undefined, family, servers, tested in parts
    ]
