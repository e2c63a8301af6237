"""Simulated runs with a known truth: error rates of tests, and coverage of intervals."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import pandas as pd
from numpy.random import Generator

from analysis.arrays import FloatArray
from analysis.stats.contrasts import ALPHA, contrasts
from analysis.stats.intervals import estimates
from analysis.tables.signature_table import SignatureTable

Shape: TypeAlias = tuple[int, ...]


@dataclass(frozen=True)
class Case:
    """Independent values with a known mean.

    Attributes:
        draw: function that returns random values of a shape.
    """

    name: str
    draw: Callable[[Generator, Shape], FloatArray]
    mean: float
    low: float = -math.inf
    high: float = math.inf


@dataclass(frozen=True)
class Errors:
    """Rates of significant tests if there is no true difference.

    Attributes:
        alone: share of tests with p <= alpha.
        families: number of tables, each with one family of tests.
        any_in_family: share of the tables with at least one significant test after Holm's correction.
    """

    tests: int
    alone: float
    families: int
    any_in_family: float


def _path_efficiency(rng: Generator, shape: Shape, solved: FloatArray) -> FloatArray:
    return np.where(solved < 0.7, rng.beta(8, 2, size=shape), 0.0)


def _efficiency(rng: Generator, shape: Shape) -> FloatArray:
    return _path_efficiency(rng, shape, rng.random(shape))


def _efficiency_difference(rng: Generator, shape: Shape) -> FloatArray:
    """Return differences between two models that mostly solve the same seeds."""
    shared, own = rng.random(shape), rng.random(shape)
    other = np.where(rng.random(shape) < 0.7, shared, own)
    return _path_efficiency(rng, shape, shared) - _path_efficiency(rng, shape, other)


def _half_zero(rng: Generator, shape: Shape) -> FloatArray:
    return np.where(rng.random(shape) < 0.5, 0.0, rng.normal(1.0, size=shape))


def _uneven(rng: Generator, shape: Shape) -> FloatArray:
    """Return multiples of .5 with ties, which have a larger spread in some seeds."""
    return np.round(2 * rng.normal(size=shape) * rng.lognormal(size=shape)) / 2


CASES = (
    Case("normal", lambda rng, shape: rng.normal(size=shape), 0.0),
    Case("exponential (skewness 2)", lambda rng, shape: rng.exponential(size=shape), 1.0, 0.0),
    Case("lognormal (skewness 6)", lambda rng, shape: rng.lognormal(size=shape), math.exp(0.5), 0.0),
    Case("Beta(9, 1), near the ceiling", lambda rng, shape: rng.beta(9, 1, size=shape), 0.9, 0.0, 1.0),
    Case("path efficiency, 30 % zeros", _efficiency, 0.7 * 0.8, 0.0, 1.0),
)
"""Values of one condition on which the coverage of intervals is measured."""
PAIRED_CASES = (
    Case("normal", lambda rng, shape: rng.normal(size=shape), 0.0),
    Case("lognormal (skewness 6)", lambda rng, shape: rng.lognormal(size=shape), math.exp(0.5)),
    Case("half zero", _half_zero, 0.5),
    Case("uneven spread, ties", _uneven, 0.0),
    Case("path efficiency", _efficiency_difference, 0.0, -1.0, 1.0),
)
"""Paired differences on which the coverage of intervals is measured."""


def coverage(
    case: Case, n: int, data_sets: int, rng: Generator, *, beside_sign_flips: bool = False
) -> dict[str, float]:
    """Return the share of data sets of n values in which foundry's interval covers the true mean.

    Keys: `covered`; `bootstrap`, the share of data sets with a bootstrap-t interval; `none`, the share of data sets
    without any interval, which count as not covered.
    """
    values = case.draw(rng, (data_sets, n))
    ends = np.full(data_sets, case.low), np.full(data_sets, case.high)
    estimated = estimates(values, *ends, beside_sign_flips=beside_sign_flips)
    return {
        "covered": float(((estimated.low <= case.mean) & (case.mean <= estimated.high)).mean()),
        "bootstrap": float((estimated.interval == "bootstrap-t").mean()),
        "none": float((estimated.interval == "").mean()),
    }


def false_positives(
    draw: Callable[[Generator, Shape], FloatArray], rng: Generator, *, tables: int, seeds: int, shared: float
) -> Errors:
    """Return the errors of the whole comparison on tables of three models and four measures that do not differ.

    A value is the sum of noise from `draw` and an effect of the seed. This effect is the same for all models and normal
    with the standard deviation `shared`. The family contains all measures for all pairs of models.
    """
    significant, alone, tests = 0, 0, 0
    for _ in range(tables):
        values = shared * rng.normal(size=(1, seeds, 4)) + draw(rng, (3, seeds, 4))
        made = simulated_table(values)
        compared = contrasts(made, family=made.measures)
        significant += bool(compared["significant"].any())
        alone += int((compared["p"] <= ALPHA).sum())
        tests += int(compared["p"].notna().sum())
    return Errors(tests, alone / tests, tables, significant / tables)


def simulated_table(values: FloatArray) -> SignatureTable:
    """Return the table of complete runs with these values (models, seeds, measures)."""
    models, seeds, count = values.shape
    measures = [f"simulated.{index}" for index in range(count)]
    keys = {
        "run": np.arange(models * seeds).astype(str),
        "world": "simulated",
        "model": np.repeat([f"model {index}" for index in range(models)], seeds),
        "prompt": "simulated",
        "seed": np.tile(np.arange(seeds), models),
        "status": "complete",
    }
    frame = pd.concat([pd.DataFrame(keys), pd.DataFrame(values.reshape(-1, count), columns=measures)], axis=1)
    return SignatureTable(frame, (), tuple(measures), (frozenset(measures),) * len(frame))
