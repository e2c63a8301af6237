"""What was declared before the runs: its tests at the looks that growing data have reached."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from analysis.arrays import FloatArray
from analysis.stats.equivalence import are_within, equivalence_p
from analysis.stats.intervals import FEWEST_FOR_CLAIMS
from analysis.stats.pairing import Paired
from analysis.stats.sequential import levels, sequential_p
from analysis.stats.testing import NOT_TESTED, corrected_in_pairs, tested
from analysis.stats.values import BoolArray, Group, SeedValues

DECLARED, EXPLORATORY = "declared", "exploratory"
"""What a row of the contrasts can claim."""
_BASELINE = NOT_TESTED + "baseline"
_TOO_EARLY = NOT_TESTED + "before the first look"


@dataclass(frozen=True)
class Plan:
    """What was declared, as far as the table of contrasts asks for it.

    Attributes:
        family: measures that are tested.
        groups: the groups that were declared; their pairs are tested.
        looks: seeds at each look, ascending (K).
        seeds: all seeds in their order; a look is at the first of them.
        reached: looks that the runs have reached, of K.
        margins: by measure, the difference below which groups count as the same.
        widest: by measure, the difference that no seed goes beyond, where that was declared.
        changed: measures whose code is no longer that of the plan: in the family, but nothing is claimed of them.
        known: what was known of the runs before, which is said of every declared row.
    """

    family: tuple[str, ...]
    groups: frozenset[Group]
    looks: tuple[int, ...]
    seeds: tuple[int, ...]
    reached: int
    margins: Mapping[str, float] = field(default_factory=dict)
    widest: Mapping[str, float] = field(default_factory=dict)
    changed: frozenset[str] = frozenset()
    known: str = ""

    def holds(self, values: SeedValues, paired: Paired) -> BoolArray:
        """Return which rows compare two declared groups (R,)."""
        known = np.array([group in self.groups for group in values.groups], dtype=np.bool_)
        return np.array([known[pair.level] and known[pair.reference] for pair in paired.pair], dtype=np.bool_)

    def at_looks(self, values: SeedValues, paired: Paired) -> Iterator[Paired]:
        """Yield the pairs of each look so far."""
        for n in self.looks[: self.reached]:
            yield paired.of_seeds(np.isin(values.seeds, self.seeds[:n]))

    def level(self, alpha: float) -> float:
        """Return the level of a single test at the last look so far; NaN before the first."""
        return float(levels(self.looks, np.array([alpha]))[self.reached - 1, 0]) if self.reached else float("nan")


def claims(plan: Plan | None, values: SeedValues, paired: Paired, frame: pd.DataFrame, alpha: float) -> dict[str, Any]:
    """Return the columns `test` and `p` of some rows, what each can claim, and `p_claim`, which corrections take.

    `p_claim` of a row of the family is corrected over the measures of its pair. That of a declared row is over all
    looks so far: the least error in all at which one of them was significant. All rows of a pair are given together.
    """
    test, p = tested(paired)
    headline, baseline = (frame[name].to_numpy(dtype=bool) for name in ("headline", "baseline"))
    test[baseline], p[baseline] = _BASELINE, np.nan
    p_claim = np.full(len(p), np.nan)
    rows = np.flatnonzero(headline)
    own = paired.of_rows(rows)
    look = np.zeros(len(p), dtype=np.int64)
    level = np.where(headline, alpha, np.nan)
    declared = np.zeros_like(headline)
    if plan is None:
        p_claim[rows] = corrected_in_pairs(own, p[rows])
    else:
        looks = list(plan.at_looks(values, own))
        results = [tested(one) for one in looks]
        test[rows], p[rows] = results[-1] if results else (_TOO_EARLY, np.nan)
        corrected = [corrected_in_pairs(one, alone) for one, (_, alone) in zip(looks, results, strict=True)]
        p_claim[rows] = sequential_p(plan.looks, np.array(corrected)) if corrected else np.nan
        look[rows], level[rows] = plan.reached, plan.level(alpha)
        declared = headline & ~frame["measure"].isin(plan.changed).to_numpy()
    claim = np.where(declared, DECLARED, EXPLORATORY)
    return {"test": test, "p": p, "p_claim": p_claim, "claim": claim, "look": look, "alpha": level}


def equivalence(
    plan: Plan | None, values: SeedValues, paired: Paired, margin: FloatArray, widest: FloatArray
) -> FloatArray:
    """Return p of the equivalence tests (R,), NaN where there is none: over all looks so far where there is a plan.

    It is 1 where a seed differs by more than what no seed goes beyond.

    Args:
        plan: what was declared.
        values: of the groups.
        paired: the pairs of R rows.
        margin: the difference below which groups count as the same (R,); NaN where there is none.
        widest: the difference that no seed goes beyond (R,).
    """
    found = np.full(len(margin), np.nan)
    rows = np.flatnonzero(~np.isnan(margin))
    own = paired.of_rows(rows)
    looks = [own] if plan is None else plan.at_looks(values, own)
    p = np.array([_equivalence_p(one, margin[rows], widest[rows]) for one in looks])
    if len(p):
        found[rows] = p[-1]
        if plan is not None:  # a one-sided test errs half as often as one of both sides
            both = sequential_p(plan.looks, np.minimum(2 * p, 1.0))
            found[rows] = np.where(np.isnan(p[-1]), np.nan, np.where(both < 1, both / 2, 1.0))
    possible = are_within(own.difference, widest[rows]) | np.isnan(own.difference)
    found[rows] = np.where(possible.all(axis=1) | np.isnan(found[rows]), found[rows], 1.0)
    return found


def _equivalence_p(paired: Paired, margin: FloatArray, widest: FloatArray) -> FloatArray:
    own = (row[~np.isnan(row)] for row in paired.difference)
    rows = zip(own, margin.tolist(), widest.tolist(), strict=True)
    return np.array([equivalence_p(*row) if len(row[0]) >= FEWEST_FOR_CLAIMS else np.nan for row in rows])
