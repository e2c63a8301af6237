"""Compares two sets of choices in the same moments, in each moment and over the seeds."""

import itertools
from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from analysis.arrays import FloatArray
from analysis.probes.choices import Answers, Chosen, MomentKey
from analysis.probes.distance import ChoiceDistance, apart
from analysis.stats.contrasts import ALPHA
from analysis.stats.intervals import estimate
from analysis.stats.pairing import hedges_g_z, superiority
from analysis.stats.sign_flip import upper_sign_flip_p
from analysis.stats.testing import p_of_row
from foundry.seeding import stream

ALL = "all"
"""The value of the column `kind` in rows over all kinds of question; only the p values of these rows are corrected."""
STANDS_OUT = 0.05
"""Level of the test in a single moment."""
EXCESS_LEVEL = 1 - 2 * ALPHA
"""Level of the intervals, so that each end belongs to a one-sided test at ALPHA."""
FIGURES = (
    "kind", "moments", "seeds", "distance", "floor", "excess", "excess_low", "excess_high", "p", "standing_out",
    "g_z", "superiority",
)  # fmt: skip


@dataclass(frozen=True)
class Compared:
    """The distance between two sets of choices, in each moment that both have."""

    moments: Mapping[MomentKey, ChoiceDistance]

    @classmethod
    def of(cls, first: Chosen, second: Chosen, what: str) -> "Compared":
        """Compare the choices in the moments that both sides have.

        Args:
            first: choices by moment.
            second: choices of the other side.
            what: name of the comparison, which names the random stream of its test; "" for no test.
        """
        rng = stream(0, f"probe:{what}") if what else None
        return cls({key: apart(first[key], second[key], rng) for key in sorted(first.keys() & second.keys())})

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for all kinds of question together, then one per kind if there are several."""
        kinds = sorted({key.kind for key in self.moments})
        return [self._row(ALL, kinds), *(self._row(kind, [kind]) for kind in kinds if len(kinds) > 1)]

    def excesses(self) -> FloatArray:
        """Return the distance minus its floor, as a mean over the moments of each seed, (seeds,)."""
        return by_seed({key: distance.excess for key, distance in self.moments.items()})

    def _row(self, name: str, kinds: Iterable[str]) -> dict[str, Any]:
        counted = set(kinds)
        chosen = {key: distance for key, distance in self.moments.items() if key.kind in counted}
        excess = Compared(chosen).excesses()
        return {
            "kind": name,
            "moments": len(chosen),
            "seeds": len(excess),
            "distance": _mean(by_seed({key: distance.distance for key, distance in chosen.items()})),
            "floor": _mean(by_seed({key: distance.floor for key, distance in chosen.items()})),
            **excess_of(excess),
            "standing_out": _mean(
                np.array([distance.p <= STANDS_OUT for distance in chosen.values()], dtype=np.float64)
            ),
        }


def compared_pairs(answers: Answers) -> list[tuple[dict[str, Any], Compared]]:
    """Compare each pair of subjects in the moments without edits, and return the names and the comparison.

    A subject is a model with its prompt.
    """
    return [
        (
            {"first": answers.names[first], "second": answers.names[second]},
            Compared.of(answers.of(first), answers.of(second), f"{answers.names[first]} and {answers.names[second]}"),
        )
        for first, second in itertools.combinations(answers.names, 2)
    ]


def compared_edits(answers: Answers) -> list[tuple[dict[str, Any], Compared]]:
    """Compare the actual choices under each edit with the expected ones; return names and comparisons."""
    edits = []
    for subject, change in answers.edited():
        model, expected = answers.names[subject], answers.expected(subject, change)
        about = {"model": model, "edit": change.name, "leaves": change.leaves, "asked": len(expected)}
        after = answers.of(subject, change.name)
        edits.append((about, Compared.of(expected, after, f"{model} {change.name}")))
    return edits


def excess_of(by_seed: FloatArray) -> dict[str, float]:
    """Return the mean over seeds of the distance minus its floor, with interval, one-sided test and effect sizes."""
    excess = estimate(by_seed, -1.0, 1.0, beside_sign_flips=True, level=EXCESS_LEVEL)
    return {
        "excess": excess.mean,
        "excess_low": excess.low,
        "excess_high": excess.high,
        "p": p_of_row(upper_sign_flip_p, by_seed),
        "g_z": float(hedges_g_z(np.array([excess.mean]), np.array([excess.sd]), excess.n)[0]),
        "superiority": float(superiority(by_seed[None, :])[0]) if len(by_seed) else np.nan,
    }


def framed(compared: Iterable[tuple[dict[str, Any], Compared]], columns: Iterable[str]) -> pd.DataFrame:
    """Return comparisons as a table, with uncorrected p and an empty column `p_holm`."""
    rows = [about | row for about, distances in compared for row in distances.rows()]
    frame = pd.DataFrame(rows, columns=[*columns, *FIGURES])
    frame.insert(list(frame.columns).index("p") + 1, "p_holm", np.nan)
    return frame


def by_seed(values: Mapping[MomentKey, float]) -> FloatArray:
    """Return for each seed the mean over its moments, (seeds,), sorted by seed, because seeds are independent units."""
    values_by_seed: dict[int, list[float]] = defaultdict(list)
    for key, value in values.items():
        values_by_seed[key.seed].append(value)
    return np.array([np.mean(mine) for _, mine in sorted(values_by_seed.items())], dtype=np.float64)


def _mean(values: FloatArray) -> float:
    return float(values.mean()) if len(values) else float("nan")
