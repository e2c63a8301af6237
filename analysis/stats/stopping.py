"""Simulates several looks: how often a difference of a known size is found, and after how many seeds."""

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
"""Maximum numbers of simulated sweeps with repeated looks, and of their seeds together."""


def with_looks(plan: pd.DataFrame, looks: Sequence[int], alpha: float = ALPHA) -> pd.DataFrame:
    """Return a plan with the power and the mean number of seeds of tests at the given looks.

    Sweeps are drawn from the pilot; each is tested at each look, at the level of that look. `power` is how often a row
    is significant at any look. `seeds` is the mean number of seeds at which a sweep ends: where the row is significant,
    else at the last look. Both use the pilot's sd; `power_cautious` and `seeds_cautious` use `sd_high`. NaN without a
    difference to find, or without spread.
    """
    columns = ("power", "seeds", "power_cautious", "seeds_cautious")
    found = pd.DataFrame(np.nan, index=plan.index, columns=list(columns))
    able = plan[(plan["sd"] > 0) & (plan["difference"] > 0)]
    for _, rows in able.groupby(list(PAIR), sort=False):
        for spread, names in (("sd", columns[:2]), ("sd_high", columns[2:])):
            found.loc[rows.index, list(names)] = _at_looks(rows, spread, looks, alpha)
    return plan.join(found)


def _at_looks(rows: pd.DataFrame, spread: str, looks: Sequence[int], alpha: float) -> FloatArray:
    """Return the power of each row of a pair, and the mean number of seeds at which its sweeps end (R, 2)."""
    rng, sizes = stream(looks[-1], "looks"), np.array(looks)
    by_look = levels(looks, np.array([alpha / int(rows["pairs"].iloc[0])]))[:, 0]
    drawn = seeds_drawn(rows, spread, looks[-1], rng)
    declared = rows["declared"].to_numpy(dtype=bool)
    found = np.stack(
        [simulated_p(drawn[..., :n], declared, level, rng)[1] <= level for n, level in zip(looks, by_look, strict=True)]
    )
    ended = np.where(found.any(axis=0), sizes[found.argmax(axis=0)], sizes[-1])
    return np.stack([found.any(axis=0).mean(axis=0), ended.mean(axis=0)], axis=1)


@lru_cache(maxsize=32)
def error_of(looks: tuple[int, ...], alpha: float) -> float:
    """Return how often t tests at the level alpha at every look are significant at some look, if nothing differs.

    It simulates normal differences.

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
