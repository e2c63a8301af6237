"""How choices depend on one quantity: the share of each choice at each of its values, and the slope.

The slope of a seed is sum (x - mean x) (y - mean y) / sum (x - mean x)^2, where x is the value of the quantity and y is
the share of a choice at this value. The means of x and y are taken within one moment, since not every moment can have
every value. This slope is a least-squares slope with an intercept for each moment. If a policy chooses without regard
to the quantity, the expected slope is 0. Slopes that are 0 in every seed are not tested.
"""

import itertools
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from analysis.arrays import FloatArray
from analysis.probes.choices import Answers, Change, Chosen, MomentKey
from analysis.probes.comparing import by_seed
from analysis.probes.probe_declaring import EVERYTHING, Family
from analysis.stats.intervals import estimate
from analysis.stats.sign_flip import sign_flip_p
from analysis.stats.testing import p_of_row

CURVES = ("model", "quantity", "kind", "choice", "value", "moments", "seeds", "share", "low", "high")
STEEPNESS = ("model", "quantity", "kind", "choice", "moments", "seeds", "slope", "low", "high", "p")


@dataclass(frozen=True)
class _Curve:
    """The share of one choice, by moment and value of the quantity."""

    about: dict[str, Any]
    shares: Mapping[MomentKey, Mapping[float, float]]


def curve_tables(answers: Answers, declared: Family = EVERYTHING) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return two tables: the share of each choice at each value of a quantity (mean over seeds), and its slope.

    The slope is the change of the share per unit of the quantity. p is corrected over the rows of declared models;
    other rows have no `p_holm`.
    """
    curves = list(_curves(answers))
    points = [curve.about | row for curve in curves for row in _points(curve)]
    slopes = pd.DataFrame([curve.about | row for curve in curves if (row := _slope(curve))], columns=list(STEEPNESS))
    slopes = slopes.assign(p_holm=np.nan)
    declared.correct(slopes)
    return pd.DataFrame(points, columns=list(CURVES)), slopes


def _curves(answers: Answers) -> Iterator[_Curve]:
    moves: dict[str, list[Change]] = defaultdict(list)
    for change in answers.changes.values():
        if change.moves:
            moves[change.moves].append(change)
    for quantity, changes in moves.items():
        asked = {
            subject: {change.to: answers.of(subject, change.name) for change in changes} for subject in answers.names
        }
        every = (pair for mine in asked.values() for chosen in mine.values() for pair in chosen.items())
        choices = sorted({(key.kind, choice) for key, counts in every for choice in counts})
        for (subject, mine), (kind, choice) in itertools.product(asked.items(), choices):
            about = {"model": answers.names[subject], "quantity": quantity, "kind": kind, "choice": choice}
            yield _Curve(about, _shares(mine, kind, choice))


def _shares(asked: Mapping[float, Chosen], kind: str, choice: str) -> dict[MomentKey, dict[float, float]]:
    by_value: dict[MomentKey, dict[float, float]] = defaultdict(dict)
    for value, chosen in asked.items():
        for key, counts in chosen.items():
            if key.kind == kind:
                by_value[key][value] = counts[choice] / counts.total()
    return by_value


def _points(curve: _Curve) -> Iterator[dict[str, Any]]:
    for value in sorted({value for mine in curve.shares.values() for value in mine}):
        shares = {key: mine[value] for key, mine in curve.shares.items() if value in mine}
        estimated = estimate(by_seed(shares), 0.0, 1.0)
        yield {"value": value, "moments": len(shares), "seeds": estimated.n, "share": estimated.mean,
               "low": estimated.low, "high": estimated.high}  # fmt: skip


def _slope(curve: _Curve) -> dict[str, Any]:
    products: dict[int, list[FloatArray]] = defaultdict(list)
    for key, mine in curve.shares.items():
        if len(mine) > 1:
            x, y = (np.array(list(part)) for part in (mine.keys(), mine.values()))
            x = x - x.mean()
            products[key.seed].append(np.array([x @ (y - y.mean()), x @ x]))
    if not products:
        return {}
    sums = np.array([np.sum(mine, axis=0) for _, mine in sorted(products.items())])
    slopes = sums[:, 0] / sums[:, 1]
    slope = estimate(slopes, beside_sign_flips=True)
    moments = sum(map(len, products.values()))
    return {"moments": moments, "seeds": slope.n, "slope": slope.mean, "low": slope.low, "high": slope.high,
            "p": p_of_row(sign_flip_p, slopes) if slopes.any() else np.nan}  # fmt: skip
