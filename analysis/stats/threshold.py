"""From which value of a setting an outcome prevails: bisection, its bracket and what is sure of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from analysis.arrays import FloatArray
from analysis.stats.intervals import wilson

Points: TypeAlias = Mapping[float, FloatArray]
"""The outcomes, 0 or 1 by run, of every value of the setting that was played."""


@dataclass(frozen=True)
class Search:
    """What is looked for.

    Attributes:
        low: least value of the setting.
        high: greatest value.
        until: width of the bracket at which the search ends.
        level: share of runs above which the outcome prevails.
        of: whole things of which each value is a share, so that none between two counts is played; None where the
            setting is no such share.
    """

    low: float
    high: float
    until: float
    level: float
    of: int | None = None

    def played(self, value: float) -> float:
        """Return what is played for a value: the nearest share that is a whole count."""
        return value if self.of is None else round(value * self.of) / self.of

    @property
    def ends(self) -> tuple[float, float]:
        """The least and the greatest value that are played."""
        return self.played(self.low), self.played(self.high)

    def between(self, low: float, high: float) -> float | None:
        """Return the value that halves a bracket, or None where it is narrow enough or there is none within."""
        middle = self.played((low + high) / 2)
        return None if high - low <= self.until or middle in (low, high) else middle


@dataclass(frozen=True)
class Threshold:
    """Where the outcome begins to prevail; NaN where an end was not found.

    Attributes:
        at: the middle of the bracket.
        low: the greatest value of the bisection at which it does not prevail.
        high: the least one at which it does; the same as `low` where the share of runs is the level itself.
        surely_low: the greatest value played whose share of runs is below the level with its whole interval.
        surely_high: the least one whose share is above it with its whole interval.
    """

    at: float
    low: float
    high: float
    surely_low: float
    surely_high: float


def next_value(search: Search, points: Points) -> float | None:
    """Return the value of the setting to play next: the ends, then the middle of the bracket; None at the end."""
    for end in search.ends:
        if end not in points:
            return end
    low, high = bracket(search, points)
    return None if math.isnan(low) or math.isnan(high) else search.between(low, high)


def bracket(search: Search, points: Points) -> tuple[float, float]:
    """Return the values between which the outcome begins to prevail, as far as the bisection has come.

    Both are the same value where the share of runs is the level itself, as half of an even number of seeds can be.
    """
    low, high = search.ends
    if prevails(points[low], search.level):
        return math.nan, low
    if not prevails(points[high], search.level):
        return high, math.nan
    while (middle := search.between(low, high)) is not None and middle in points:
        if math.isclose(float(points[middle].mean()), search.level):
            return middle, middle
        low, high = (low, middle) if prevails(points[middle], search.level) else (middle, high)
    return low, high


def prevails(outcomes: FloatArray, level: float) -> bool:
    """Tell whether more than this share of outcomes are 1."""
    return float(outcomes.mean()) > level


def threshold(search: Search, points: Points) -> Threshold:
    """Return what was found; its surer bounds are by Wilson's 95 % intervals over runs, each value by itself."""
    low, high = bracket(search, points)
    ends = {value: share_of(outcomes) for value, outcomes in points.items()}
    below = [value for value, (_, _, upper) in ends.items() if upper < search.level]
    above = [value for value, (_, lower, _) in ends.items() if lower > search.level]
    return Threshold((low + high) / 2, low, high, max(below, default=math.nan), min(above, default=math.nan))


def share_of(outcomes: FloatArray) -> tuple[float, float, float]:
    """Return the share of outcomes that are 1, and the ends of its interval (Wilson 1927)."""
    rate = np.array([outcomes.mean()])
    lower, upper = wilson(rate, len(outcomes))
    return float(rate[0]), float(lower[0]), float(upper[0])
