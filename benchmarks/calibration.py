"""Measures what the statistics promise, on simulated runs whose truth is known: `python benchmarks/calibration.py`."""

from __future__ import annotations

import math
import sys

import numpy as np
from measuring import Stopwatch, print_table, print_title

from analysis.stats.calibration import CASES, coverage, false_positives, simulated_table
from analysis.stats.contrasts import contrasts
from analysis.stats.fingerprint import swap_p

SIZES = (5, 10, 20)
DATA_SETS = 6_000
TABLES = 1_000
MARGIN = 0.4


def other_shapes(rng: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    """Return models of equal means, the first of which is normal and the others lognormal."""
    values = rng.lognormal(size=shape)
    values[0] = math.exp(0.5) + rng.normal(size=shape[1:])
    return values


NOISE = {
    "normal": lambda rng, shape: rng.normal(size=shape),
    "lognormal": lambda rng, shape: rng.lognormal(size=shape),
    "path efficiency": CASES[4].draw,
    "outcome 0 or 1": lambda rng, shape: (rng.random(shape) < 0.7).astype(float),
    "equal means, other shapes": other_shapes,
}
UNSHARED = {"outcome 0 or 1"}
"""Noise that an effect of the seed would make something else of."""


def intervals() -> None:
    print_title("Coverage of the 95 % intervals in use", f"{DATA_SETS:,} data sets; error of a figure .003 to .005.")
    rows = []
    for case in CASES:
        found = [coverage(case, n, DATA_SETS, np.random.default_rng(n)) for n in SIZES]
        rows.append(
            [case.name, *(f"{one['covered']:.3f}" for one in found), *(f"{one['bootstrap']:.0%}" for one in found)]
        )
    heads = [f"n = {n}" for n in SIZES]
    print_table(["values", *heads, *(f"bootstrap-t, {head}" for head in heads)], rows)


def tests() -> None:
    print_title(
        "False positives of the whole comparison, nothing differs",
        f"{TABLES:,} tables of 3 models x 4 measures, a family of 12 tests; error of the last column .007.",
    )
    rows = []
    for name, draw in NOISE.items():
        for seeds in (6, 10, 20):
            shared = 0.0 if name in UNSHARED else 1.0
            found = false_positives(draw, np.random.default_rng(seeds), tables=TABLES, seeds=seeds, shared=shared)
            rows.append([name, seeds, f"{found.tests:,}", f"{found.alone:.3f}", f"{found.any_in_family:.3f}"])
    print_table(["noise", "seeds", "tests", "p <= .05", "family with any after Holm"], rows)


def equivalence() -> None:
    print_title("Equivalence claimed with the difference at the margin, and at 0", "4,000 contrasts a row; error .004.")
    rows = []
    for difference in (MARGIN, 0.0):
        for seeds in (6, 10, 20):
            rng = np.random.default_rng(seeds)
            values = rng.normal(size=(1, seeds, 4000)) + 0.5 * rng.normal(size=(2, seeds, 4000))
            table = simulated_table(values + np.array([0, difference])[:, None, None])
            found = contrasts(table, margins=dict.fromkeys(table.measures, MARGIN))
            rows.append([f"{difference:g}", seeds, f"{(found['p_equivalence'] <= 0.05).mean():.3f}"])
    print_table(["true difference (margin 0.4, sd .71)", "seeds", "p_equivalence <= .05"], rows)


def fingerprints() -> None:
    print_title("Energy test of whole fingerprints, 8 measures", f"{TABLES:,} pairs of models; error .007.")
    rows = []
    for shift in (0.0, 0.5):
        for seeds in (6, 10, 20):
            rng = np.random.default_rng(seeds)
            found = [_energy_p(rng, seeds, shift) for _ in range(TABLES)]
            rows.append([f"{shift:g} sd in every measure", seeds, f"{np.mean(np.array(found) <= 0.05):.3f}"])
    print_table(["true difference", "seeds", "p <= .05"], rows)


def _energy_p(rng: np.random.Generator, seeds: int, shift: float) -> float:
    shared = rng.normal(size=(seeds, 8)) * math.sqrt(0.5)
    first, second = (shared + rng.normal(size=(seeds, 8)) * math.sqrt(0.5) for _ in range(2))
    return swap_p(first, second + shift)


if __name__ == "__main__":
    watch = Stopwatch()
    intervals()
    tests()
    equivalence()
    fingerprints()
    print(f"{watch.cost().wall_s:.0f} s in all", file=sys.stderr)
