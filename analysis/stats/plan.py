"""Tests declared measures at those planned looks that the runs have reached."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from analysis.arrays import FloatArray, IntArray
from analysis.stats.equivalence import are_within, equivalence_p
from analysis.stats.intervals import FEWEST_FOR_CLAIMS
from analysis.stats.pairing import Paired
from analysis.stats.sequential import levels, sequential_p
from analysis.stats.testing import NOT_TESTED, corrected_in_pairs, tested
from analysis.stats.values import BoolArray, Group, SeedValues

DECLARED, EXPLORATORY = "declared", "exploratory"
"""The values of the column `claim` in the table of contrasts."""
_BASELINE = NOT_TESTED + "baseline"
_TOO_EARLY = NOT_TESTED + "before the first look"


@dataclass(frozen=True)
class Plan:
    """The content of a declaration, as far as the table of contrasts depends on it.

    Attributes:
        groups: the declared groups; all their pairs are tested.
        looks: number of seeds at each look, ascending (K).
        seeds: all seeds in their order; a look at n seeds uses the first n.
        reached: number of looks, of the K, that the runs have reached.
        changed: measures whose code changed after the plan; they stay in the family, but support no claims.
        known: note on what was known of the runs before the plan; it is added to every declared row.
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
        """Yield, for each reached look, the pairs of the seeds up to this look."""
        for n in self.looks[: self.reached]:
            yield paired.of_seeds(np.isin(values.seeds, self.seeds[:n]))

    def until(self, values: SeedValues, look: IntArray) -> BoolArray:
        """Return whether each row uses each seed, (R, S): the seeds up to the row's look.

        A row whose look is 0 has no look and uses all seeds.
        """
        places = {seed: place for place, seed in enumerate(self.seeds)}
        place = np.array([places.get(seed, len(places)) for seed in values.seeds])
        seeds = np.array([np.inf, *self.looks])[look]
        return np.asarray(place < seeds[:, None])

    def levels(self, alpha: float) -> FloatArray:
        """Return the level of a single test at each look (K + 1,); index 0, for no look, is NaN."""
        return np.append(np.nan, levels(self.looks, np.array([alpha]))[:, 0])

    def over_looks(self, p: FloatArray) -> tuple[FloatArray, IntArray]:
        """Return each row's p value over all looks so far, (R,), and the number of the look that gives it, (R,).

        The p of a row is the least error over all looks for which the row is significant at one of the reached looks.

        Args:
            p: two-sided p at the reached looks (k, R), k >= 1; NaN where nothing was tested.
        """
        errors = np.array([sequential_p(self.looks, p[:look]) for look in range(1, len(p) + 1)])
        return errors[-1], errors.argmin(axis=0) + 1


def claims(plan: Plan | None, values: SeedValues, paired: Paired, frame: pd.DataFrame, alpha: float) -> dict[str, Any]:
    """Return the columns `test`, `p`, `claim`, `look` and `alpha` of these rows, and `p_claim`, the p value of a claim.

    `p_claim` of a row of the family is corrected over the measures of its pair. For a declared row it is the least
    overall error at which any look so far was significant. `look` of such a row is the look at which a difference was
    found, else the look at which equivalence was found, else the last look so far. All rows of a pair must be given
    together.

    Args:
        plan: what was declared.
        values: of the groups.
        paired: the pairs of R rows.
        frame: columns `headline`, `baseline` and `measure` of the rows, and the columns that `equivalence` returns.
        alpha: level of the tests.
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
        tests, alone = [np.full(len(rows), _TOO_EARLY, dtype=object)], [np.full(len(rows), np.nan)]
        for test_at_look, p_at_look in map(tested, looks):
            tests.append(test_at_look)
            alone.append(p_at_look)
        if looks:
            corrected = [corrected_in_pairs(look, p_alone) for look, p_alone in zip(looks, alone[1:], strict=True)]
            p_claim[rows], decisive = plan.over_looks(np.array(corrected))
            same = frame.loc[rows, "p_equivalence"] <= alpha
            otherwise = np.where(same, frame.loc[rows, "look_same"], plan.reached)
            look[rows] = np.where(p_claim[rows] <= alpha, decisive, otherwise)
        at = look[rows], np.arange(len(rows))
        test[rows], p[rows] = np.array(tests)[at], np.array(alone)[at]
        level[rows] = plan.levels(alpha)[look[rows]]
        declared = headline & ~frame["measure"].isin(plan.changed).to_numpy()
    claim = np.where(declared, DECLARED, EXPLORATORY)
    return {"test": test, "p": p, "p_claim": p_claim, "claim": claim, "look": look, "alpha": level}


def equivalence(
    plan: Plan | None, values: SeedValues, paired: Paired, margin: FloatArray, widest: FloatArray
) -> dict[str, Any]:
    """Test whether groups are equal within the margin, and return two columns, `p_equivalence` and `look_same`.

    `p_equivalence` is the p value, or NaN if equality is not tested. `look_same` is the look that decides.

    With a plan, p covers all reached looks. It is 1 if a seed differs by more than `widest`.

    Args:
        plan: the declaration, if there is one.
        values: values of the groups.
        paired: the pairs of R rows.
        margin: the difference below which groups count as equal (R,); NaN without a margin.
        widest: the largest possible difference of a seed (R,).
    """
    p_equal, look = np.full(len(margin), np.nan), np.zeros(len(margin), dtype=np.int64)
    rows = np.flatnonzero(~np.isnan(margin))
    own = paired.of_rows(rows)
    looks = [own] if plan is None else plan.at_looks(values, own)
    p = np.array([_equivalence_p(look, margin[rows], widest[rows]) for look in looks])
    if len(p):
        p_equal[rows] = p[-1]
        if plan is not None:  # a one-sided test errs half as often as a two-sided one
            both, look[rows] = plan.over_looks(np.minimum(2 * p, 1.0))
            p_equal[rows] = np.where(np.isnan(p[-1]), np.nan, np.where(both < 1, both / 2, 1.0))
    possible = are_within(own.difference, widest[rows]) | np.isnan(own.difference)
    p_equal[rows] = np.where(possible.all(axis=1) | np.isnan(p_equal[rows]), p_equal[rows], 1.0)
    return {"p_equivalence": p_equal, "look_same": look}


def _equivalence_p(paired: Paired, margin: FloatArray, widest: FloatArray) -> FloatArray:
    own = (row[~np.isnan(row)] for row in paired.difference)
    rows = zip(own, margin.tolist(), widest.tolist(), strict=True)
    return np.array([equivalence_p(*row) if len(row[0]) >= FEWEST_FOR_CLAIMS else np.nan for row in rows])
