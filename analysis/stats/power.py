"""Estimates how many seeds a test needs, from the paired differences of a pilot sweep."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from analysis.arrays import BoolArray, FloatArray, IntArray
from analysis.stats.contrasts import ALPHA
from analysis.stats.family import headline_measures, primary_measures, unknown_measure
from analysis.stats.max_t import TIES, scaled, signs_of_simulations
from analysis.stats.pairing import Paired, pair_of, pair_up, row_frame
from analysis.stats.sign_flip import fewest_pairs
from analysis.stats.values import SeedValues, seed_values
from analysis.tables.signature_table import SignatureTable
from analysis.tables.table import Table
from analysis.tables.texts import number
from foundry.errors import InputError
from foundry.seeding import stream

MOST_SEEDS = 100_000
MOST_RECOMMENDED = 200
"""Maximum number of seeds to recommend; differences that need more are not planned for."""
CAUTION = 0.8
"""Confidence level of the upper bound of the standard deviation, which a cautious plan uses."""
_POINTS = 500
"""Number of points for integrating over a distribution."""
SIMULATED = (6, 7, 8, 9, 10, 11, 12, 14, 16, 18, 20, 24, 28, 32, 40, 48, 64)
"""Numbers of seeds for which the test itself is simulated; for more seeds, t tests approximate it well."""
RESAMPLES = 300
_FEWER = 0.7
"""Simulations of the sign-flip test start with this share of the number of seeds that a t test needs."""
_ROUNDING = 1e-12
"""A pilot's difference counts as 0 if it is at most this share of its standard deviation: it comes from rounding."""
NO_PAIRS, NO_SPREAD, NO_DIFFERENCE, TOO_MANY = (
    "fewer than two pairs",
    "no variation in the pilot",
    "no difference to find",
    f"more than {MOST_SEEDS:,} seeds",
)

COLUMNS = (
    "measure", "factor", "level", "reference", "context", "n_pairs", "observed", "sd", "sd_high", "difference",
    "n_alone", "family", "n_exact", "n_family", "n_cautious", "note", "declared",
)  # fmt: skip
"""The columns of the written plan, in their order."""
_OF_PILOT = ("pairs", "differences")
"""Columns that only the simulations need: the number of tested pairs of the factor, and the pilot's differences."""
PAIR = ("factor", "level", "reference", "context")


def power(
    table: SignatureTable,
    groups: pd.DataFrame | None = None,
    *,
    measure: str | None = None,
    difference: float | None = None,
    target: float = 0.8,
    alpha: float = ALPHA,
) -> pd.DataFrame:
    """Return how many seeds each contrast needs, with one row per pair of groups and measure.

    - n_alone: the least n of `SIMULATED` at which the sign-flip test of this contrast alone has the power.
    - n_family: the least n for the max-T test with the declared measures of its pair, at alpha / the pairs of the
      factor. It is at least `n_exact`, the least n that can reach this level.
    - n_cautious: `n_family` computed with `sd_high`, the upper 80 % bound of the pilot's standard deviation.
    - note: the reason why there is no n; n is then NaN.
    - declared: whether claims may be based on the measure. These measures come first.
    - pairs, differences: input of `stopping.with_looks`.

    Simulations draw the pilot's seeds with replacement, and shift their differences to the wanted mean. If more seeds
    are needed than the last of `SIMULATED`, n is that of a t test at alpha / `family`.

    Args:
        table: the pilot's runs.
        groups: the columns that define groups, one row per run; by default the swept settings.
        measure: the only measure of interest; by default the headline measures.
        difference: the difference to be found, in the unit of the measure; by default the difference of the pilot. That
            difference is uncertain, and on average too large if the pilot was chosen for its large difference.
        target: the wanted power.
        alpha: level of the tests.

    Raises:
        InputError: the measure does not exist, or a number is out of its range.
    """
    _check(table, measure, difference, target)
    frame = _pilot(table, groups, measure)
    observed = frame["observed"].abs()
    observed = observed.mask(observed <= _ROUNDING * frame["sd"], 0.0)
    return seeds_needed(frame, observed if difference is None else difference, target, alpha)


def seeds_needed(
    frame: pd.DataFrame, difference: float | pd.Series[float], target: float, alpha: float = ALPHA
) -> pd.DataFrame:
    """Add to each row of a pilot how many seeds it needs; see `power`.

    Args:
        frame: a row per measure and pair, with the columns `PAIR`, `measure`, `n_pairs`, `observed`, `sd`,
            `differences`, `declared`, `family` and `pairs`.
        difference: the difference to be found.
        target: the wanted power.
        alpha: level of the two-sided tests.
    """
    n, sd = (frame[name].to_numpy(dtype=np.float64) for name in ("n_pairs", "sd"))
    frame["sd_high"] = sd_bound(sd, n)
    frame["difference"] = difference
    by_pairs = (alpha / frame["pairs"]).tolist()
    fewest = {pair: fewest_pairs(pair) for pair in set(by_pairs)}
    frame["n_exact"] = np.array([fewest[pair] or np.nan for pair in by_pairs], dtype=np.float64)
    frame[["n_alone", "n_family", "n_cautious"]] = np.nan
    for _, rows in frame.groupby(list(PAIR), sort=False):
        frame.loc[rows.index, ["n_alone", "n_family"]] = _needed(rows, "sd", alpha, target)
        frame.loc[rows.index, "n_cautious"] = _needed(rows, "sd_high", alpha, target)[:, 1]
    for name in ("n_family", "n_cautious"):
        frame[name] = np.maximum(frame[name], frame["n_exact"])
    return frame.assign(note=_notes(frame))[[*COLUMNS, *_OF_PILOT]]


def recommended(plan: pd.DataFrame) -> pd.DataFrame:
    """Return how many seeds each pair of groups needs for its declared measures, or for all if none is declared.

    - seeds: the largest `n_cautious` of its measures, among those that need at most MOST_RECOMMENDED.
    - enough: the measures for which this number is enough, from the one that needs the most seeds.
    - beyond: the measures that need more than MOST_RECOMMENDED.
    - without_n: number of measures without an n.
    """
    rows = plan[plan["declared"]] if plan["declared"].any() else plan
    recommendations = []
    for pair, measures in rows.groupby(list(PAIR), sort=False):
        needs = measures["n_cautious"]
        within = measures[needs <= MOST_RECOMMENDED].sort_values("n_cautious", ascending=False, kind="stable")
        recommendations.append(
            dict(zip(PAIR, pair, strict=True))
            | {
                "seeds": within["n_cautious"].max(),
                "enough": tuple(within["measure"]),
                "beyond": tuple(measures.loc[needs > MOST_RECOMMENDED, "measure"]),
                "without_n": int(needs.isna().sum()),
            }
        )
    return pd.DataFrame(recommendations, columns=[*PAIR, "seeds", "enough", "beyond", "without_n"])


def power_table(plan: pd.DataFrame) -> Table:
    """Return the whole plan as a readable table."""
    rows = [
        (row["measure"], pair_name(row), str(row["n_pairs"]), number(row["sd"]), number(row["difference"]),
         *(seeds_text(row[name]) for name in ("n_alone", "n_family", "n_cautious")), row["note"])
        for row in plan.to_dict("records")
    ]  # fmt: skip
    caption = (
        "Number of seeds for the requested power. Alone: a single test. In the family: a test corrected by max-T. "
        "Cautious: the corrected test, computed with the upper 80 % bound of the pilot's standard deviation."
    )
    columns = ("measure", "contrast", "pairs", "sd", "difference", "alone", "in the family", "cautious", "note")
    return Table("power", caption, columns, tuple(rows), labels=2)


def pair_name(row: Mapping[Hashable, Any]) -> str:
    """Return the pair of a row as text, such as `herd - random`."""
    return f"{row['level']} - {row['reference']}" + (f" ({row['context']})" if row["context"] else "")


def seeds_text(seeds: float) -> str:
    """Return a number of seeds as text, or `-` for NaN."""
    return "-" if np.isnan(seeds) else f"{seeds:.0f}"


def _needed(rows: pd.DataFrame, spread: str, alpha: float, target: float) -> FloatArray:
    """Return how many seeds each test of a pair needs: uncorrected, and corrected over the family, (R, 2).

    NaN if no number of seeds is enough.
    """
    difference, sd = (rows[name].to_numpy(dtype=np.float64) for name in ("difference", spread))
    effect = _effect(np.where(difference > 0, difference, np.nan), sd)
    levels = np.stack([np.full(len(rows), alpha), alpha / rows["family"].to_numpy(dtype=np.float64)], axis=1)
    needed = np.stack([pairs_needed(effect, level, target) for level in levels.T], axis=1)
    seeds = np.where(needed <= SIMULATED[-1], SIMULATED[-1] + 1, needed)
    is_able, is_declared = ~np.isnan(effect), rows["declared"].to_numpy(dtype=bool)
    is_open = (needed[:, :1] <= SIMULATED[-1]) & ~np.isnan(seeds)
    for n in SIMULATED:
        # The sign-flip test needs at least about as many seeds as the t test.
        tried = is_open.any(axis=1) & (n >= _FEWER * needed[:, 0])
        if tried.any():
            simulated = np.flatnonzero(tried | (is_able & is_declared))
            reached = np.zeros_like(is_open)
            reached[simulated] = _simulated_power(rows.iloc[simulated], spread, n, alpha) >= target
            reached &= is_open & tried[:, None]
            seeds[reached] = n
            is_open &= ~reached
    return seeds


def _simulated_power(rows: pd.DataFrame, spread: str, n: int, alpha: float) -> FloatArray:
    """Return the power of each test of a pair with n seeds: uncorrected, and corrected over the family, (R, 2)."""
    rng, level = stream(n, "power"), alpha / int(rows["pairs"].iloc[0])
    drawn = seeds_drawn(rows, spread, n, rng)
    alone, family = simulated_p(drawn, rows["declared"].to_numpy(dtype=bool), level, rng)
    return np.stack([(alone <= alpha).mean(axis=0), (family <= level).mean(axis=0)], axis=1)


def seeds_drawn(rows: pd.DataFrame, spread: str, n: int, rng: np.random.Generator) -> FloatArray:
    """Return the differences of simulated sweeps (sweeps, R, n), with seeds drawn from the pilot with replacement.

    Args:
        rows: rows of one pair; the pilot's `differences` are shifted to the mean `difference`.
        spread: the column with the standard deviation to which the differences are scaled.
        n: number of seeds of a simulated sweep.
        rng: draws the seeds.
    """
    pilot = np.array(rows["differences"].tolist())
    mean, sd, spread_planned, difference = (
        rows[name].to_numpy(dtype=np.float64)[:, None] for name in ("observed", "sd", spread, "difference")
    )
    few = np.sqrt(1 - 1 / rows["n_pairs"].to_numpy(dtype=np.float64))[:, None]
    moved = np.copysign(difference, mean) + (pilot - mean) * spread_planned / sd / few
    picked = rng.integers(0, pilot.shape[1], size=(RESAMPLES, n))
    return np.asarray(np.nan_to_num(moved)[:, picked].swapaxes(0, 1))


def simulated_p(
    drawn: FloatArray, declared: BoolArray, level: float, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Return two p values for each row of a pair and each simulated sweep: alone, and corrected over declared rows.

    Args:
        drawn: differences (sweeps, R, seeds); both results are (sweeps, R).
        declared: which rows are declared (R,).
        level: the least p that the test must be able to reach.
        rng: draws the signs of the test.
    """
    signs, values = signs_of_simulations(drawn.shape[2], level, rng).T, scaled(drawn)
    least = np.abs(values.sum(axis=2))[..., None] - TIES
    alone, family = np.empty(drawn.shape[:2]), np.empty(drawn.shape[:2])
    for sweep, (own, bound) in enumerate(zip(values, least, strict=True)):
        null = np.abs(own @ signs)
        is_extreme = null >= bound
        alone[sweep] = is_extreme.mean(axis=1)
        largest = null[declared].max(axis=0, initial=0.0)
        family[sweep] = (is_extreme | (largest >= bound)).mean(axis=1)
    return alone, family


def sd_bound(sd: FloatArray, n: FloatArray) -> FloatArray:
    """Return upper bounds, (k,), at confidence CAUTION, of standard deviations that were estimated from n values each.

    The values are normally distributed.
    """
    from scipy.special import chdtri

    freedom = np.maximum(n - 1, 1)
    return np.asarray(sd * np.sqrt(freedom / chdtri(freedom, CAUTION)))


def pairs_needed(effect: FloatArray, level: FloatArray, target: float) -> FloatArray:
    """Return the smallest number of pairs (k,) with which two-sided paired t tests have the wanted power.

    Args:
        effect: |difference| / sd (k,); NaN and 0 give NaN.
        level: level of each test (k,).
        target: the wanted power.
    """
    from scipy.special import ndtri

    needed = np.full(len(effect), np.nan)
    # The normal approximation is a lower bound; from a few dozen pairs on it is close.
    roughly = ((ndtri(1 - level / 2) + ndtri(target)) / np.where(effect > 0, effect, np.nan)) ** 2
    able = np.flatnonzero(roughly < MOST_SEEDS)
    low = np.maximum(roughly[able].astype(np.int64) - 1, 2)
    high = 3 * low + 50
    while (low < high).any():
        middle = (low + high) // 2
        enough = paired_power(effect[able], middle, level[able]) >= target
        low, high = np.where(enough, low, np.minimum(middle + 1, high)), np.where(enough, middle, high)
    needed[able] = low
    return needed


def paired_power(effect: FloatArray, n: IntArray, level: FloatArray) -> FloatArray:
    """Return the power of two-sided paired t tests (k,), from the noncentral t distribution.

    The integral over the sample's standard deviation is a mean over equally likely points, because library routines
    fail for large noncentralities.
    """
    from scipy.special import chdtri, ndtr, stdtrit

    freedom = (n - 1)[:, None]
    spread = np.sqrt(chdtri(freedom, (np.arange(_POINTS) + 0.5) / _POINTS) / freedom)
    critical = stdtrit(n - 1, 1 - level / 2)[:, None] * spread
    noncentral = (effect * np.sqrt(n))[:, None]
    return np.asarray((ndtr(noncentral - critical) + ndtr(-noncentral - critical)).mean(axis=1))


def _check(table: SignatureTable, measure: str | None, difference: float | None, target: float) -> None:
    if measure is not None and measure not in table.measures:
        raise unknown_measure(measure, table.measures)
    check_wanted(difference, target)


def check_wanted(difference: float | None, target: float) -> None:
    """Raise an InputError if the difference is not positive, or the power is not between 0 and 1."""
    if difference is not None and not difference > 0:
        raise InputError(f"The difference is {difference:g}: give one above 0, in the unit of the measure.")
    if not 0 < target < 1:
        raise InputError(f"The power is {target:g}: give a probability between 0 and 1, such as 0.8.")


def _pilot(table: SignatureTable, groups: pd.DataFrame | None, measure: str | None) -> pd.DataFrame:
    """Return a row per contrast of the pilot: number of pairs, mean and spread of the differences, size of family."""
    values, primary = seed_values(table, groups), primary_measures(table.measures, table.present)
    frame = pd.concat([_pilot_rows(values, paired, primary) for paired in pair_up(values)], ignore_index=True)
    tested = frame["headline"] & (frame["sd"] > 0)
    frame.insert(7, "family", tested.groupby(frame["factor"]).transform("sum").clip(lower=1))
    pair = pair_of(frame)
    frame["pairs"] = pair.where(tested).groupby(frame["factor"]).transform("nunique").clip(lower=1)
    wanted = headline_measures(values.measures) if measure is None else (measure,)
    frame = frame[frame["measure"].isin(wanted) & ~frame["baseline"]].rename(columns={"headline": "declared"})
    return frame.sort_values("declared", ascending=False, kind="stable", ignore_index=True)


def _pilot_rows(values: SeedValues, paired: Paired, primary: Sequence[str]) -> pd.DataFrame:
    estimated = paired.estimates()
    frame = row_frame(values, paired, primary)
    frame = frame[["measure", "headline", "baseline", "factor", "level", "reference", "context"]]
    sd = np.where(estimated.n > 1, estimated.sd, np.nan)
    return frame.assign(n_pairs=estimated.n, observed=estimated.mean, sd=sd, differences=list(paired.difference))


def _effect(difference: FloatArray, sd: FloatArray) -> FloatArray:
    return np.asarray(difference / np.where(sd > 0, sd, np.nan))


def _notes(frame: pd.DataFrame) -> npt.NDArray[np.object_]:
    sd, difference, n = (frame[name].to_numpy(dtype=np.float64) for name in ("sd", "difference", "n_cautious"))
    causes = [(np.isnan(sd), NO_PAIRS), (sd == 0, NO_SPREAD), (difference == 0, NO_DIFFERENCE), (np.isnan(n), TOO_MANY)]
    return np.select([cause for cause, _ in causes], [text for _, text in causes], default="").astype(object)
