"""Simulates tests at several looks: how often they find a known difference, and after how many seeds."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import pandas as pd

from analysis.arrays import FloatArray
from analysis.stats.contrasts import ALPHA
from analysis.stats.power import PAIR, seeds_drawn, simulated_p
from analysis.stats.sequential import levels
from foundry.seeding import stream

MOST_PATHS, MOST_DRAWS = 20_000, 8_000_000
"""Maximum number of simulated sweeps, and maximum number of all their seeds together."""


def with_looks(plan: pd.DataFrame, looks: Sequence[int], alpha: float = ALPHA) -> pd.DataFrame:
    """Add to a plan the power and the mean number of seeds of tests at the given looks.

    Simulated sweeps are drawn from the pilot, and tested at each look at the level of that look.

    - power: how often a row is significant at any look.
    - seeds: the mean number of seeds at which a sweep ends, which is when the row is significant, or the last look.
    - power_cautious, seeds_cautious: the same, computed with `sd_high` instead of the pilot's standard deviation.

    They are NaN if there is no difference to find, or no spread.
    """
    columns = ("power", "seeds", "power_cautious", "seeds_cautious")
    shares = pd.DataFrame(np.nan, index=plan.index, columns=list(columns))
    able = plan[(plan["sd"] > 0) & (plan["difference"] > 0)]
    for _, rows in able.groupby(list(PAIR), sort=False):
        for spread, names in (("sd", columns[:2]), ("sd_high", columns[2:])):
            shares.loc[rows.index, list(names)] = _at_looks(rows, spread, looks, alpha)
    return plan.join(shares)


def _at_looks(rows: pd.DataFrame, spread: str, looks: Sequence[int], alpha: float) -> FloatArray:
    rng, sizes = stream(looks[-1], "looks"), np.array(looks)
    by_look = levels(looks, np.array([alpha / int(rows["pairs"].iloc[0])]))[:, 0]
    drawn = seeds_drawn(rows, spread, looks[-1], rng)
    declared = rows["declared"].to_numpy(dtype=bool)
    shares = np.stack(
        [simulated_p(drawn[..., :n], declared, level, rng)[1] <= level for n, level in zip(looks, by_look, strict=True)]
    )
    ended = np.where(shares.any(axis=0), sizes[shares.argmax(axis=0)], sizes[-1])
    return np.stack([shares.any(axis=0).mean(axis=0), ended.mean(axis=0)], axis=1)


@lru_cache(maxsize=32)
def error_of(looks: tuple[int, ...], alpha: float) -> float:
    """Return the probability that the test at one look or more is significant although nothing differs.

    Each look makes a t test at the level alpha. The probability is simulated with normally distributed differences.

    Args:
        looks: pairs at each look, ascending (K).
        alpha: level of each look.
    """
    from scipy.special import stdtrit

    sizes = np.array(looks)
    shape = min(MOST_PATHS, MOST_DRAWS // looks[-1]), looks[-1]
    drawn = stream(looks[-1], "stopping").standard_normal(shape)
    sums, squares = (values.cumsum(axis=1)[:, sizes - 1] for values in (drawn, drawn**2))
    spread = squares - sums**2 / sizes
    critical = stdtrit(sizes - 1, 1 - alpha / 2)
    return float((np.abs(sums) >= critical * np.sqrt(sizes * spread / (sizes - 1))).any(axis=1).mean())
