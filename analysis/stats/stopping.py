"""What a difference of a known size comes to when data are tested at several looks: how often it is found, and when."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import pandas as pd

from analysis.arrays import BoolArray, FloatArray, IntArray
from analysis.stats.contrasts import ALPHA
from analysis.stats.sequential import levels
from foundry.seeding import stream

PATHS, MOST_PATHS, MOST_DRAWS = 4_000, 20_000, 8_000_000
"""Simulated sweeps of a plan; of what repeated looks come to, and seeds of all of those together."""


@dataclass(frozen=True)
class Stopped:
    """Of R differences.

    Attributes:
        power: how often each is found at one of the looks (R,).
        seeds: at how many seeds the sweep ends on average (R,): where it is found, else at the last look.
    """

    power: FloatArray
    seeds: FloatArray


def with_looks(plan: pd.DataFrame, looks: Sequence[int], alpha: float = ALPHA) -> pd.DataFrame:
    """Return a plan with what comes of testing at these looks, as one test of its family.

    `power` and `seeds` (to the look that finds it, on average) are with the pilot's sd, `power_cautious` and
    `seeds_cautious` with `sd_high`; NaN where there is no difference to find, or no spread.

    Args:
        plan: as `analysis.stats.power.power` returns it.
        looks: seeds at each look, ascending.
        alpha: error in all of the family.
    """
    level = alpha / plan["family"].to_numpy(dtype=np.float64)
    difference = plan["difference"].to_numpy(dtype=np.float64)
    found: dict[str, FloatArray] = {}
    for name, ending in (("sd", ""), ("sd_high", "_cautious")):
        sd = plan[name].to_numpy(dtype=np.float64)
        one = stopped(looks, difference / np.where((sd > 0) & (difference > 0), sd, np.nan), level)
        found |= {f"power{ending}": one.power, f"seeds{ending}": one.seeds}
    return plan.assign(**found)


def stopped(looks: Sequence[int], effect: FloatArray, alpha: FloatArray) -> Stopped:
    """Return what becomes of paired t tests of normal differences at the levels of these looks, by simulation.

    Args:
        looks: seeds at each look, ascending (K).
        effect: true means in standard deviations (R,); NaN stays.
        alpha: error in all of each test (R,).
    """
    sizes, walks, level = np.array(looks), _walks(tuple(looks), PATHS), levels(looks, alpha)
    rows = []
    for row, one in enumerate(effect):
        found = _significant(sizes, walks, one, level[:, row])
        ended = np.where(found.any(axis=1), sizes[found.argmax(axis=1)], sizes[-1])
        rows.append((np.nan, np.nan) if np.isnan(one) else (found.any(axis=1).mean(), ended.mean()))
    return Stopped(*np.array(rows).reshape(-1, 2).T)


@lru_cache(maxsize=32)
def error_of(looks: tuple[int, ...], alpha: float) -> float:
    """Return how often t tests at the level alpha at every look are significant at any, where nothing differs.

    By simulation of normal differences.

    Args:
        looks: pairs at each look, ascending (K).
        alpha: level of each look.
    """
    walks = _walks(looks, min(MOST_PATHS, MOST_DRAWS // looks[-1]))
    return float(_significant(np.array(looks), walks, 0.0, np.full(len(looks), alpha)).any(axis=1).mean())


def _walks(looks: tuple[int, ...], paths: int) -> tuple[FloatArray, FloatArray]:
    """Return the sums of normal draws and of their squares at each look (paths, K)."""
    drawn = stream(looks[-1], "stopping").standard_normal((paths, looks[-1]))
    at = np.array(looks) - 1
    return drawn.cumsum(axis=1)[:, at], (drawn**2).cumsum(axis=1)[:, at]


def _significant(sizes: IntArray, walks: tuple[FloatArray, FloatArray], effect: float, level: FloatArray) -> BoolArray:
    """Return at which looks a t test of the draws, moved by the effect, is significant (paths, K)."""
    from scipy.special import stdtrit

    sums, squares = walks
    total = sums + sizes * effect
    spread = squares + 2 * effect * sums + sizes * effect**2 - total**2 / sizes
    return np.asarray(np.abs(total) >= stdtrit(sizes - 1, 1 - level / 2) * np.sqrt(sizes * spread / (sizes - 1)))
