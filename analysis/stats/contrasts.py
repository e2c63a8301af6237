"""Computes the differences between groups of runs, paired by seed, with intervals and tests."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from analysis.arrays import IntArray
from analysis.stats.equivalence import are_within
from analysis.stats.family import are_apart, declared_measures, is_denominator, known_measures
from analysis.stats.intervals import Estimates, by_count
from analysis.stats.max_t import over_pairs
from analysis.stats.pairing import Paired, bounds, hedges_g_z, mean_where, pair_of, pair_up, row_frame, superiority
from analysis.stats.plan import DECLARED, Plan, claims, equivalence
from analysis.stats.sign_flip import least_p
from analysis.stats.testing import benjamini_hochberg, holm
from analysis.stats.values import SeedValues, seed_values
from analysis.tables.groups import group_keys, swept_columns
from analysis.tables.signature_table import SignatureTable
from analysis.tables.texts import number, with_interval
from foundry.errors import InputError
from foundry.texts import counted

ALPHA = 0.05


def contrasts(
    table: SignatureTable,
    groups: pd.DataFrame | None = None,
    *,
    family: Sequence[str] | None = None,
    margins: Mapping[str, float] | None = None,
    alpha: float = ALPHA,
    repeating: Mapping[str, str] | None = None,
    plan: Plan | None = None,
) -> pd.DataFrame:
    """Return a row per measure and pair of groups that differ in only one factor, with the difference and its tests.

    `docs/formats.md` explains each column.

    Args:
        table: the runs.
        groups: columns that define groups, one row per run; by default the swept settings.
        family: measures of the declared family of tests; by default, for each signature, the first headline measure
            that all worlds have.
        margins: by measure, the declared difference below which groups count as equal.
        alpha: level of the tests.
        repeating: by model, a note that its server does not repeat its replies; rows about the model get this note.
        plan: the declaration before the runs; its measures and margins replace `family` and `margins`.

    Raises:
        InputError: a measure of the family or of a margin does not exist, or a margin is not positive.
    """
    values = seed_values(table, groups)
    declared = declared_measures(family if plan is None else plan.family, values.measures, table.present)
    margins = _checked((margins or {}) if plan is None else plan.margins, values.measures)
    servers = _servers(values, table, groups, repeating or {})
    asked = _Asked(declared, margins, plan, alpha, servers)
    blocks = [_row_by_row(values, paired, asked) for paired in pair_up(values)]
    frame = pd.concat([rows for rows, _ in blocks], ignore_index=True)
    all_estimates = Estimates.joined([estimated for _, estimated in blocks])
    frame = frame.assign(**_over_families(frame, alpha))
    frame = frame.assign(out_of_reach=_out_of_reach(frame, plan, alpha))
    return frame.assign(note=_notes(frame, all_estimates, asked.plan))[list(COLUMNS)]


@dataclass(frozen=True)
class _Asked:
    """The settings that all rows share.

    Attributes:
        servers: a note on the server of each group (G).
    """

    declared: Sequence[str]
    margins: Mapping[str, float]
    plan: Plan | None
    alpha: float
    servers: Sequence[str]


COLUMNS = (
    "measure", "signature", "headline", "readable_only", "baseline", "factor", "level", "reference", "context",
    "n_pairs", "n_missing", "n_undefined", "mean_level", "mean_reference", "difference", "low", "high", "interval",
    "test", "p", "claim", "look", "alpha", "p_adjusted", "family", "pairs", "significant", "p_bh", "g_z", "superiority",
    "bound_low", "bound_high", "margin", "widest", "n_within", "p_equivalence", "p_equivalence_holm", "equivalent",
    "out_of_reach", "note",
)  # fmt: skip
"""The columns of the table of contrasts, in their order."""


def _checked(margins: Mapping[str, float], measures: Sequence[str]) -> Mapping[str, float]:
    known_measures(list(margins), measures)
    for name, margin in margins.items():
        if not 0 < margin < math.inf:
            raise InputError(f"The margin of {name} is {margin:g}: use a value above 0, in the unit of the measure.")
    return margins


def _servers(
    values: SeedValues, table: SignatureTable, groups: pd.DataFrame | None, repeating: Mapping[str, str]
) -> list[str]:
    keys = group_keys(swept_columns(table) if groups is None else groups)
    models = dict(zip(keys, table.frame["model"].astype(str), strict=True))
    return [repeating.get(models[group], "") for group in values.groups]


def _row_by_row(values: SeedValues, paired: Paired, asked: _Asked) -> tuple[pd.DataFrame, Estimates]:
    """Return the columns of the contrasts whose values depend on one row only, and the means with their intervals.

    The numbers of a declared row come from the look at which its result was decided.
    """
    frame, plan = row_frame(values, paired, asked.declared), asked.plan
    if plan is not None:
        frame["headline"] &= plan.holds(values, paired)
    frame = frame.assign(**_equivalence(values, paired, frame, asked))
    frame = frame.assign(**claims(plan, values, paired, frame, asked.alpha))
    said = [dict.fromkeys((asked.servers[pair.level], asked.servers[pair.reference])) for pair in paired.pair]
    frame = frame.assign(servers=["; ".join(filter(None, both)) for both in said])
    look = frame["look"].to_numpy(dtype=np.int64)
    seen = paired if plan is None else paired.where(plan.until(values, look))
    latest = paired if plan is None else paired.where(plan.until(values, np.where(look > 0, plan.reached, 0)))
    frame = frame.assign(n_latest=_count(latest), later=_later(seen, paired))
    row_estimates = seen.estimates()
    margin = frame["margin"].to_numpy(dtype=np.float64)
    within = np.where(np.isnan(margin), np.nan, are_within(seen.difference, margin).sum(axis=1))
    frame = frame.assign(n_within=within, **_sizes(seen, row_estimates))
    low, high = bounds(seen)
    return frame.assign(**_effects(seen, row_estimates), bound_low=low, bound_high=high), row_estimates


def _count(paired: Paired) -> IntArray:
    return np.asarray((~np.isnan(paired.difference)).sum(axis=1))


def _later(seen: Paired, paired: Paired) -> list[str]:
    """Return the difference over all seeds in words, for each row whose test used only some seeds; "" for others."""
    texts = np.full(len(paired.pair), "", dtype=object)
    rows = np.flatnonzero(_count(seen) < _count(paired))
    whole = paired.of_rows(rows).estimates()
    for row, n, *ends in zip(rows, whole.n, whole.mean, whole.low, whole.high, strict=True):
        texts[row] = f"over all {n} seeds the difference is {with_interval(*ends)}"
    return list(texts)


def _sizes(paired: Paired, estimated: Estimates) -> dict[str, Any]:
    both = ~np.isnan(paired.difference)
    return {
        "n_pairs": estimated.n,
        "n_missing": paired.missing.sum(axis=1),
        "n_undefined": paired.undefined.sum(axis=1),
        "mean_level": mean_where(paired.level, both),
        "mean_reference": mean_where(paired.reference, both),
        "difference": estimated.mean,
        "low": estimated.low,
        "high": estimated.high,
        "interval": estimated.interval,
    }


def _over_families(frame: pd.DataFrame, alpha: float) -> dict[str, Any]:
    pair = pair_of(frame).to_numpy(dtype=np.int64)
    p, p_claim, p_equivalence = (frame[name].to_numpy(dtype=np.float64) for name in ("p", "p_claim", "p_equivalence"))
    explored = ~frame["readable_only"].to_numpy(dtype=bool)
    explored &= ~np.array([is_denominator(name) for name in frame["measure"].tolist()], dtype=bool)
    headline = frame["headline"].to_numpy(dtype=bool)
    apart = are_apart(frame["measure"].tolist())
    adjusted, rates, same = (np.full(len(p), np.nan) for _ in range(3))
    size, pairs = np.zeros(len(p), dtype=np.int64), np.zeros(len(p), dtype=np.int64)
    for factor in frame["factor"].unique():
        own = (frame["factor"] == factor).to_numpy()
        family = own & headline
        adjusted[family] = np.where(np.isnan(p[family]), np.nan, over_pairs(p_claim[family], pair[family]))
        same[own] = holm(p_equivalence[own])
        for some in (~apart, apart):
            rates[own & explored & some] = benjamini_hochberg(p[own & explored & some])
        is_test = ~np.isnan(p_claim[family])
        size[family], pairs[family] = np.count_nonzero(is_test), len(np.unique(pair[family][is_test]))
    columns = {"p_adjusted": adjusted, "family": size, "pairs": pairs, "significant": adjusted <= alpha, "p_bh": rates}
    return {**columns, "p_equivalence_holm": same, "equivalent": same <= alpha}


def _effects(paired: Paired, estimated: Estimates) -> dict[str, Any]:
    g_z, above = np.full(len(estimated.n), np.nan), np.full(len(estimated.n), np.nan)
    for rows, differences in by_count(paired.difference):
        g_z[rows] = hedges_g_z(estimated.mean[rows], estimated.sd[rows], differences.shape[1])
        above[rows] = superiority(differences)
    return {"g_z": g_z, "superiority": above}


def _equivalence(values: SeedValues, paired: Paired, frame: pd.DataFrame, asked: _Asked) -> dict[str, Any]:
    """Return the columns of the test of equivalence.

    If the difference of a seed is larger than `widest`, the column `beyond` has a sentence that says so.
    """
    margin = np.array([asked.margins.get(name, np.nan) for name in frame["measure"].tolist()], dtype=np.float64)
    margin[frame["baseline"] if asked.plan is None else ~frame["headline"]] = np.nan
    declared = {} if asked.plan is None else asked.plan.widest
    largest = np.array([declared.get(name, np.inf) for name in frame["measure"].tolist()], dtype=np.float64)
    widest = np.where(np.isnan(margin), np.nan, np.minimum(paired.high - paired.low, largest))
    beyond = np.fmax.reduce(np.abs(paired.difference), axis=1)
    beyond = np.where(are_within(beyond[:, None], widest)[:, 0], np.nan, beyond)
    return {
        "beyond": [
            f"one seed differs by {number(size)}, more than --widest {number(most)}: equality cannot be claimed"
            if size > most
            else ""
            for size, most in zip(beyond, widest, strict=True)
        ],
        "margin": margin,
        "widest": widest,
        **equivalence(asked.plan, values, paired, margin, widest),
    }


def _out_of_reach(frame: pd.DataFrame, plan: Plan | None, alpha: float) -> list[str]:
    """Return the reason why a row could not have become significant, given the results of the other rows, or "".

    Holm's correction multiplies the least p of a row by the number of pairs that have a test without significance.
    """
    is_open = (frame["family"] > 0) & frame["p"].notna() & ~frame["significant"]
    pair = pair_of(frame).where(is_open)
    left = pair.groupby(frame["factor"]).transform("nunique").where(is_open, 0).astype(int)
    strictest = {
        pairs_left: alpha / pairs_left if plan is None else plan.levels(alpha / pairs_left)[plan.reached]
        for pairs_left in {*left} - {0}
    }
    columns = (frame["n_latest"], frame["pairs"], left, frame["look"])
    return [
        f"with {seeds} seeds, no p value can be as low as {alpha:g} after correction for {counted(pairs, 'pair')}"
        + (" at this look" if look else "")
        if open_pairs and least_p(seeds) > strictest[open_pairs]
        else ""
        for seeds, pairs, open_pairs, look in zip(*columns, strict=True)
    ]


def _notes(frame: pd.DataFrame, estimated: Estimates, plan: Plan | None) -> list[str]:
    known = plan.known if plan else ""
    columns = (
        frame[name].tolist()
        for name in ("n_missing", "n_undefined", "out_of_reach", "later", "beyond", "servers", "claim")
    )
    return [
        "; ".join(
            part
            for part in (
                note,
                f"missing in {missing} of {n + missing + undefined} seeds" if missing else "",
                f"undefined in {undefined} of {n + missing + undefined} seeds" if undefined else "",
                unreachable,
                later,
                beyond,
                servers,
                known if claim == DECLARED else "",
            )
            if part
        )
        for note, n, missing, undefined, unreachable, later, beyond, servers, claim in zip(
            estimated.note, estimated.n, *columns, strict=True
        )
    ]
