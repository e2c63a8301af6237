"""Sweeps whose truth is known: which sentences must be said of them, and which must not."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest

from analysis.paper.summary import summary
from analysis.stats.contrasts import contrasts
from analysis.stats.plan import Plan
from analysis.tables.comparison import compare
from analysis.tables.groups import swept_columns
from signature_tables import MEASURE, runs, table

NAN = math.nan
UNBOUNDED = "path.made_up"
SUCCESS = "path_efficiency.success"
MORE, LESS, NONE, SAME = "stays where it is more often", "stays where it is less often", "No difference", "are the same"
WITHIN_TENTH = {"margins": {MEASURE: 0.1}}


def noise(n: int, seed: int = 0, spread: float = 0.02) -> np.ndarray:
    return np.random.default_rng([n, seed]).normal(0, spread, size=n)


def two(differences: Sequence[float], measure: str = MEASURE, **more: object) -> list[dict[str, Any]]:
    """Return runs of a model a at 0.3 and of a model b that differs from it by this in each seed."""
    return [*runs("a", [0.3] * len(differences), measure, **more), *_beside(differences, measure, **more)]


def _beside(differences: Sequence[float], measure: str, **more: object) -> list[dict[str, Any]]:
    made = runs("b", [0.3 + difference for difference in differences], measure, **more)
    return [one for one, difference in zip(made, differences, strict=True) if not math.isinf(difference)]


def many(*means: float, n: int) -> list[dict[str, Any]]:
    """Return runs of models a, b, ... around these means."""
    return [run for at, mean in enumerate(means) for run in runs("abcdefgh"[at], (mean + noise(n, at)).tolist())]


def planned(looks: Sequence[int], reached: int, measure: str = MEASURE, **more: Any) -> dict[str, Any]:
    groups = frozenset({("a",), ("b",)})
    return {"plan": Plan((measure,), groups, tuple(looks), tuple(range(looks[-1])), reached, **more)}


GONE = math.inf
"""Marks a seed of b whose run is missing."""
HALF = [0.1, -0.1] * 5
TURNED = [0.4, 0.41, 0.39, 0.42, 0.38, 0.4, 0.43, 0.37, -0.3, -0.3, -0.3, -0.3, -0.3, -0.3, -0.3, -0.3, -0.3, -0.3]

CASES: dict[str, tuple[list[dict[str, Any]], Mapping[str, Any], Sequence[str], Sequence[str]]] = {
    "b is higher": (many(0.2, 0.5, n=8), {}, [f"b {MORE} than a", "8 seeds"], [NONE, SAME, LESS]),
    "b is lower": (many(0.5, 0.2, n=8), {}, [f"b {LESS} than a"], [NONE, SAME, MORE]),
    "signs are half and half": (two(HALF), {}, [NONE, "find large differences alone"], [MORE, LESS, SAME]),
    "6 seeds that agree are enough": (two([0.1, 0.2, 0.1, 0.3, 0.2, 0.1]), {}, [MORE, "p = .031"], [NONE]),
    "6 seeds with one tie are not": (two([0.1, 0.2, 0.1, 0.3, 0.2, 0]), {}, [NONE, "p = .062"], [MORE]),
    "5 seeds only describe": (two([0.3] * 4 + [0.2]), {}, ["fewer than 6 seeds only describe"], [MORE, NONE, SAME]),
    "6 of 10 seeds differ, 4 tie": (two([0.1, 0.2, 0.3, 0.1, 0.2, 0.1] + [0] * 4), {}, [MORE], [NONE]),
    "4 of 10 seeds differ, 6 tie": (two([0.1, 0.2, 0.3, 0.1] + [0] * 6), {}, [NONE, "[0, "], [MORE]),
    "a constant difference has no interval": (two([0.2] * 10), {}, [MORE, "difference 0.2, 10 seeds"], ["["]),
    "an outlier against all others": (two([0.01] * 9 + [-0.3]), {}, [NONE], [MORE, LESS]),
    "an outlier beside all others": (two([0.01] * 9 + [0.6]), {}, [MORE, "[0.01, "], [LESS]),
    "equal in every seed": (two([0.0] * 10), {}, ["both are equal in every seed"], [SAME, NONE, MORE]),
    "equal within rounding": (two([1e-17] * 10), {}, ["both are equal in every seed"], [SAME, NONE, MORE]),
    "equal in 10 seeds, with a margin": (
        two([0.0] * 10), WITHIN_TENTH, ["all 10 seeds lie within 0.1", "up to 26 %", "needs at least 29 seeds"], [SAME],
    ),
    "equal in 28 seeds, with a margin": (two([0.0] * 28), WITHIN_TENTH, ["needs at least 29"], [SAME]),
    "equal in 29 seeds, with a margin": (two([0.0] * 29), WITHIN_TENTH, [SAME], ["could differ by more"]),
    "fails in one seed of 10": (two([0.0] * 9 + [0.7]), WITHIN_TENTH, ["9 of 10 seeds lie", "up to 39 %"], [SAME]),
    "fails in one seed of 30": (two([0.0] * 29 + [0.7]), WITHIN_TENTH, ["29 of 30", "not shown to be"], [SAME]),
    "a difference at the margin": (two((0.1 + noise(40)).tolist()), WITHIN_TENTH, [MORE], [SAME, "too small"]),
    "small but sure": (
        two((0.02 + noise(60, spread=0.01)).tolist()), WITHIN_TENTH, [MORE, "so too small to count"], [NONE],
    ),
    "no range": (
        two([0.01, -0.01] * 20, UNBOUNDED), {"margins": {UNBOUNDED: 0.1}, "family": [UNBOUNDED]},
        ["all 40 seeds lie within 0.1", "since the measure has no range"], [SAME],
    ),
    "a run is missing": (
        two([*[0.3] * 9, GONE]), {},
        [MORE, "missing in 1 of 10 seeds", "from 0.24 to 0.34"], ["turn it round"],
    ),
    "half of the runs are missing": (
        two([0.1, 0.2, 0.15, 0.1, 0.3, 0.1, *[GONE] * 6]), {},
        [MORE, "6 seeds", "missing in 6 of 12 seeds", "from -0.0708 to 0.429, so they could turn it round"], [],
    ),
    "a run of a measure without a range is missing": (
        two([*[0.3] * 9, GONE], UNBOUNDED), {"family": [UNBOUNDED]}, ["leave any difference possible"], [],
    ),
    "undefined in two seeds": (two([*[0.3] * 8, NAN, NAN]), {}, [MORE, "undefined in 2 of 10"], ["missing"]),
    "undefined in all seeds": (two([NAN] * 10), {}, ["no seed has a value in both"], [MORE, NONE, SAME]),
    "outcomes of 6 seeds differ": (
        [*runs("a", [0] * 10, SUCCESS), *runs("b", [1] * 6 + [0] * 4, SUCCESS)], {}, ["p = .031"], [NONE],
    ),
    "outcomes of 5 seeds differ": (
        [*runs("a", [0] * 10, SUCCESS), *runs("b", [1] * 5 + [0] * 5, SUCCESS)], {}, [NONE, "p = .062"], [],
    ),
    "a heavy tail, no difference": (
        two((0.05 * np.random.default_rng(5).standard_cauchy(12)).clip(-0.3, 0.3).tolist()), {}, [NONE], [MORE, LESS],
    ),
    "one model of three differs": (
        many(0.2, 0.2, 0.6, n=10), {},
        [f"c {MORE} than each other model", f"{NONE} was found between b and a"], [LESS],
    ),
    "6 seeds are too few for three models": (
        many(0.1, 0.4, 0.8, n=6), {}, ["no p can reach 0.05 with 6 seeds among 3 pairs"], [MORE, NONE, SAME],
    ),
    "7 seeds are enough for three models": (
        many(0.1, 0.4, 0.8, n=7), {}, [f"c {MORE} than each other model", "1 further pair differs"], [NONE],
    ),
    "8 seeds are too few for five models": (many(0.1, 0.3, 0.5, 0.7, 0.9, n=8), {}, ["10 pairs"], [MORE, LESS, SAME]),
    "9 seeds are enough for five models": (
        many(0.1, 0.3, 0.5, 0.7, 0.9, n=9), {},
        [f"e {MORE} than each other model", "6 further pairs differ"], [NONE],
    ),
    "worlds disagree": (
        two((0.2 + noise(10)).tolist(), world="v") + two((noise(10) - 0.2).tolist(), world="w"), {},
        [f"b {MORE} than a (world=v)", f"b {LESS} than a (world=w)"], [],
    ),
    "a difference in one world alone": (
        two((0.2 + noise(10)).tolist(), world="v") + two(HALF, world="w"), {},
        [f"b {MORE} than a (world=v)", f"{NONE} was found between b and a (world=w)"], [f"b {MORE} than a (world=w)"],
    ),
    "prompts of one model": (
        [*runs("a", [0.3] * 8, prompt="x"), *runs("a", (0.6 + noise(8)).tolist(), prompt="y")], {},
        [f"With prompt=y a {MORE} than with prompt=x"], [LESS],
    ),
    "before the first look": (two([0.3] * 7), planned((8, 18), 0), ["not all runs of the first declared look"], [MORE]),
    "decided at a look, turned later": (
        two(TURNED), planned((8, 18), 2),
        [f"b {MORE} than a", "0.4 [0.383, 0.417], 8 seeds", "over all 18 seeds the difference is 0.0111"], [LESS],
    ),
    "nothing at two looks": (two(HALF + HALF[:8]), planned((8, 18), 2), [NONE, "18 seeds"], [MORE, LESS, "over all"]),
    "seeds beyond the last look": (
        two(HALF + [0.6] * 10), planned((10,), 1), [NONE, "10 seeds", "over all 20 seeds"], [MORE],
    ),
    "8 seeds within a declared widest difference": (
        two([0.0] * 8), planned((8,), 1, margins={MEASURE: 0.1}, widest={MEASURE: 0.3}), [SAME], [],
    ),
    "a later seed goes beyond the widest difference": (
        two([0.0] * 8 + [0.4]), planned((8,), 1, margins={MEASURE: 0.1}, widest={MEASURE: 0.3}),
        ["a seed differs by 0.4, beyond the declared 0.3"], [SAME],
    ),
}  # fmt: skip


@pytest.mark.parametrize(("made", "options", "says", "never"), CASES.values(), ids=CASES.keys())
def test_a_sweep_of_known_truth_is_told_as_it_is(
    made: list[dict[str, Any]], options: Mapping[str, Any], says: Sequence[str], never: Sequence[str]
):
    found = table(made)
    columns = swept_columns(found)
    rows = contrasts(found, columns, **options)
    sentences = summary(rows, compare(found, columns), planned="plan" in options)
    text = " ".join(one for one in sentences if "all of this explores" not in one)
    assert [part for part in says if part not in text] == [], text
    assert [part for part in never if part in text] == [], text
    claimed = rows[rows["significant"]]
    excluded = (claimed["low"] > 0) | (claimed["high"] < 0) | claimed["low"].isna()
    assert excluded.all(), "a claim stands beside an interval that holds 0"
