"""Agreement of every two models beyond chance, and of each with itself: a matrix.

Two answers in the same moment agree with chance a, two in different moments of the same kind of question with chance c:
kappa = (a - c) / (1 - c) (after Cohen 1960, with chance as what is left where it does not matter which moment it was).
Of a model with itself both are over different repeats. For whoever is blind to the moment its mean is 0. Intervals are
of the jackknife over seeds (Efron and Tibshirani 1993, An Introduction to the Bootstrap, chapter 11).
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from analysis.arrays import FloatArray
from analysis.probes.choices import Answers, Chosen, MomentKey
from analysis.probes.comparing import ALL
from analysis.stats.intervals import estimate
from analysis.tables.table import Table
from analysis.tables.texts import told_rows

COLUMNS = ("first", "second", "moments", "seeds", "agreement", "chance", "kappa", "low", "high")


@dataclass(frozen=True)
class _Sums:
    """What agreement is made of in the moments of one seed and kind.

    Attributes:
        moments: how many there are.
        agreed: sum over them of the chance that two answers agree.
        first: sum over them of the first one's shares (choices,).
        second: of the second one's.
        same: sum over them of the products of both one's shares.
    """

    moments: int
    agreed: float
    first: FloatArray
    second: FloatArray
    same: float


def matrix_of(answers: Answers) -> pd.DataFrame:
    """Return the agreement of every two subjects, and of each with itself, where nothing is edited."""
    pairs = itertools.combinations_with_replacement(answers.names, 2)
    rows = [
        {"first": answers.names[first], "second": answers.names[second]} | found
        for first, second in pairs
        if (found := _row(answers.of(first), answers.of(second), itself=first == second))
    ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def matrix_table(matrix: pd.DataFrame, agreement: pd.DataFrame) -> Table:
    """Return the matrix: kappa above the diagonal and on it, the excess of the total variation below it."""
    names = list(dict.fromkeys([*matrix["first"], *matrix["second"]]))
    every = agreement[agreement["kind"] == ALL]
    kappa = {(row["first"], row["second"]): row["kappa"] for row in told_rows(matrix, (), {"kappa": ("low", "high")})}
    apart = {
        (row["second"], row["first"]): row["excess"]
        for row in told_rows(every, (), {"excess": ("excess_low", "excess_high")})
    }
    rows = tuple((one, *((kappa | apart).get((one, other), "") for other in names)) for one in names)
    caption = (
        "Above the diagonal the agreement of two models beyond chance (kappa), on it that of each with itself, with "
        "95 % intervals over seeds; below it the total variation above its floor, with 90 % intervals."
    )
    return Table("agreement_matrix", caption, ("model", *names), rows if len(names) > 1 else (), labels=1)


def _row(first: Chosen, second: Chosen, *, itself: bool) -> dict[str, Any]:
    keys = sorted(key for key in first.keys() & second.keys() if not itself or first[key].total() > 1)
    parts: dict[int, dict[str, _Sums]] = {}
    for kind in sorted({key.kind for key in keys}):
        mine = [key for key in keys if key.kind == kind]
        choices = sorted({choice for chosen in (first, second) for key in mine for choice in chosen[key]})
        for seed, group in itertools.groupby(mine, key=lambda key: key.seed):
            parts.setdefault(seed, {})[kind] = _sums(first, second, list(group), choices, itself)
    if not parts:
        return {}
    agreed, chance = _agreement(list(parts.values()))
    left_out = [_kappa(*_agreement([mine for other, mine in parts.items() if other != seed])) for seed in parts]
    kappa, n = _kappa(agreed, chance), len(parts)
    found = estimate(n * kappa - (n - 1) * np.array(left_out), -1.0, 1.0)
    return {"moments": len(keys), "seeds": n, "agreement": agreed, "chance": chance, "kappa": kappa,
            "low": found.low, "high": found.high}  # fmt: skip


def _sums(first: Chosen, second: Chosen, keys: Sequence[MomentKey], choices: Sequence[str], itself: bool) -> _Sums:
    a, b = (
        np.array([[chosen[key][one] for one in choices] for key in keys], dtype=float) for chosen in (first, second)
    )
    m, n = a.sum(axis=1), b.sum(axis=1)
    agreed = (a * (a - 1)).sum(axis=1) / (m * (m - 1)) if itself else (a * b).sum(axis=1) / (m * n)
    x, y = a / m[:, None], b / n[:, None]
    return _Sums(len(keys), float(agreed.sum()), x.sum(axis=0), y.sum(axis=0), float((x * y).sum()))


def _agreement(seeds: Sequence[Mapping[str, _Sums]]) -> tuple[float, float]:
    """Return the chances that two answers agree, in the same moment and in different ones of its kind."""
    agreed = chance = 0.0
    moments = 0
    for kind in {kind for seed in seeds for kind in seed}:
        sums = [seed[kind] for seed in seeds if kind in seed]
        mine = sum(one.moments for one in sums)
        if mine < 2:
            continue
        first, second = np.sum([one.first for one in sums], axis=0), np.sum([one.second for one in sums], axis=0)
        agreed += sum(one.agreed for one in sums)
        chance += (float(first @ second) - sum(one.same for one in sums)) / (mine - 1)
        moments += mine
    return (agreed / moments, chance / moments) if moments else (np.nan, np.nan)


def _kappa(agreed: float, chance: float) -> float:
    return (agreed - chance) / (1 - chance) if chance < 1 else np.nan
