"""Computes, before the first call, how many seeds a sweep's tests need, and which difference they can detect."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from analysis.form import form_of
from analysis.planned.declaring import compared_pairs
from analysis.signatures import discover
from analysis.stats.contrasts import ALPHA
from analysis.stats.intervals import FEWEST_FOR_CLAIMS
from analysis.stats.max_t import TIES, scaled, signs_of_simulations
from analysis.stats.sign_flip import fewest_pairs
from foundry.seeding import stream
from foundry.storing.preregistration import PlannedCondition
from foundry.texts import counted

CHANCE = 0.8
"""A difference counts as detectable if the test finds it with this probability."""
SIMULATIONS = 400
_MOST_EFFECT, _HALVINGS = 20.0, 8


@dataclass(frozen=True)
class Reach:
    """The power of a sweep's tests.

    Attributes:
        pairs: number of pairs of levels of the factor.
        fewest: minimum number of seeds at which a test can be significant.
    """

    seeds: int
    pairs: int
    factor: str
    fewest: int
    measures: int

    @property
    def is_enough(self) -> bool:
        """True if a test can be significant."""
        return self.seeds >= self.fewest

    @cached_property
    def effect(self) -> float:
        """The difference that is detected with probability CHANCE, in standard deviations; NaN with too few seeds."""
        return sure_effect(self.seeds, self.pairs, self.measures) if self.is_enough else math.nan

    def line(self) -> str:
        """Return the power of the tests in words."""
        pairs = f"{counted(self.pairs, 'pair')} of {self.factor}s need" + "s" * (self.pairs == 1)
        needed = f"{pairs} at least {self.fewest} seeds"
        if not self.is_enough:
            return f"{needed}: with {self.seeds} seeds, no difference can be claimed"
        return (
            f"{needed}; with {self.seeds} seeds, a difference of {self.effect:.1f} standard deviations is found with a "
            f"chance of {CHANCE:.0%}"
        )


def reach_of(conditions: Sequence[PlannedCondition], forms: Sequence[str], measures: int = 0) -> Reach | None:
    """Return the power of a sweep's tests; None if the sweep compares nothing.

    If `measures` is 0, the tests are of one measure per signature that is tested by default.
    """
    played = [(condition, form) for condition, form in zip(conditions, forms, strict=True) if condition.runs]
    factors = [factor for factor, _ in compared_pairs(*map(list, zip(*played, strict=True)))]
    if not factors:
        return None
    factor = max(dict.fromkeys(factors), key=factors.count)
    pairs = factors.count(factor)
    seeds = len({seed for condition in conditions for seed in condition.runs.values()})
    fewest = max(fewest_pairs(ALPHA / pairs) or 0, FEWEST_FOR_CLAIMS)
    return Reach(seeds, pairs, factor, fewest, measures or _headlines(forms))


def _headlines(forms: Sequence[str]) -> int:
    runs = [form_of(form).run for form in dict.fromkeys(forms)]
    parts = [[signature.part(run) for signature in discover()] for run in runs]
    return max(sum(part is not None and part.primary for part in own) for own in parts)


def sure_effect(seeds: int, pairs: int, measures: int) -> float:
    """Return the smallest difference of one measure that is detected with probability CHANCE, in standard deviations.

    Normal differences of independent measures are simulated, and one measure has an effect. The test is max-T within
    the pair, at the level of the first step of Holm's method.
    """
    draws = stream(seeds, "reach")
    noise = draws.standard_normal((SIMULATIONS, measures, seeds))
    signs = signs_of_simulations(seeds, ALPHA / pairs, draws)
    others = np.abs(scaled(noise[:, 1:]) @ signs.T).max(axis=1, initial=0.0)
    low, high = 0.0, _MOST_EFFECT
    for _ in range(_HALVINGS):
        effect = (low + high) / 2
        values = scaled(noise[:, 0] + effect)
        p = (np.maximum(np.abs(values @ signs.T), others) >= np.abs(values.sum(axis=1))[:, None] - TIES).mean(axis=1)
        low, high = (low, effect) if (p * pairs <= ALPHA).mean() >= CHANCE else (effect, high)
    return high
