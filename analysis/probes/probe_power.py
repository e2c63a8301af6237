"""How many seeds, moments and repeats a probe needs, judged by a pilot probe.

The excess of a seed is the mean over its T moments, so its variance over seeds is b + w(n) / T: b between seeds, w(n)
between the moments of a seed that are asked n times. What of w is due to the repeats is told by asking as if only half
of them had been made (drawn among those that were): w(n) = m + c / n, so c / n = w(n / 2) - w(n).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.random import Generator

from analysis.arrays import FloatArray
from analysis.probes.choices import Answers, Chosen, MomentKey, read_answers
from analysis.probes.comparing import values_by_seed
from analysis.probes.distance import gap
from analysis.probes.probe_declaring import Family
from analysis.stats.contrasts import ALPHA
from analysis.stats.intervals import FEWEST_FOR_CLAIMS
from analysis.stats.max_t import TIES, scaled, signs_of_simulations
from analysis.stats.power import (
    NO_DIFFERENCE,
    NO_PAIRS,
    NO_SPREAD,
    RESAMPLES,
    SIMULATED,
    TOO_MANY,
    pairs_needed,
)
from foundry.errors import InputError
from foundry.seeding import stream
from foundry.storing.store import SweepFolder

HALVED = 20
"""Times that half of the repeats are drawn."""
COLUMNS = (
    "comparison", "seeds", "moments", "repeats", "observed", "difference", "sd", "between", "by_moments", "by_repeats",
    "family", "n", "n_moments", "n_repeats", "note",
)  # fmt: skip


def probe_power(
    folder: SweepFolder,
    names: Sequence[str] = (),
    *,
    difference: float | None = None,
    target: float = 0.8,
    alpha: float = ALPHA,
) -> pd.DataFrame:
    """Return how many seeds each comparison needs: as the pilot is, with twice its moments, with twice its repeats.

    `n` is the least tried number of seeds at which the one-sided sign-flip test at alpha / `family` has the power, by
    drawing the pilot's seeds with replacement; above 64 seeds it is that of t tests, which are close there. `sd` is
    that of a seed's excess. Its variance is the sum of `between`, `by_moments` and `by_repeats`; `moments` is the mean
    number of moments of a seed.

    Args:
        folder: the pilot probe.
        names: the models and edits that the probe is to declare; nothing: all.
        difference: the excess that is to be found, 0..1; by default the pilot's.
        target: power wanted.
        alpha: level of the tests.

    Raises:
        InputError: a number is out of its range, or a name is no model or edit.
        RecordError: a recorded file is damaged.
    """
    if difference is not None and not 0 < difference <= 1:
        raise InputError(f"The difference is {difference:g}: an excess is above 0 and at most 1.")
    if not 0 < target < 1:
        raise InputError(f"The power is {target:g}: give a probability between 0 and 1, such as 0.8.")
    answers = read_answers(folder.runs())
    found = [
        {"comparison": name} | _pilot(first, second, name)
        for name, first, second in _comparisons(answers, Family.of(names, answers))
    ]
    family = max(sum(one["sd"] > 0 for one in found), 1)
    rows = [one | _needed(one, difference, target, alpha / family) | {"family": family} for one in found]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _comparisons(answers: Answers, family: Family) -> Iterator[tuple[str, Chosen, Chosen]]:
    """Yield the declared comparisons: what they are called, and both sides' choices."""
    for first, second in family.pairs(answers):
        yield f"{answers.names[first]} - {answers.names[second]}", answers.of(first), answers.of(second)
    for subject, change in family.edited(answers):
        name = f"{answers.names[subject]}: {change.name}"
        yield name, answers.expected(subject, change), answers.of(subject, change.name)


def _pilot(first: Chosen, second: Chosen, name: str) -> dict[str, Any]:
    """Return the excess of a comparison, and what the variance of a seed's is made of."""
    keys = sorted(first.keys() & second.keys())
    values = values_by_seed({key: gap(first[key], second[key]) for key in keys})
    moments = float(np.mean([len(mine) for mine in values])) if values else np.nan
    means = np.array([mine.mean() for mine in values])
    variance = float(means.var(ddof=1)) if len(means) > 1 else np.nan
    within = _within(values) / moments
    by_repeats = min(_halved(first, second, keys, name) / moments - within, within) if keys else np.nan
    by_repeats = 0.0 if np.isnan(by_repeats) else max(by_repeats, 0.0)
    within = min(within, variance) if not np.isnan(variance) else within
    return {
        "seeds": len(means),
        "moments": moments,
        "repeats": max((first[key].total() for key in keys), default=0),
        "excesses": means,
        "observed": float(means.mean()) if len(means) else np.nan,
        "sd": float(np.sqrt(variance)),
        "between": variance - within,
        "by_moments": within - min(by_repeats, within),
        "by_repeats": min(by_repeats, within),
    }


def _within(values: Sequence[FloatArray]) -> float:
    """Return the pooled variance of moments within their seeds; 0 where no seed has two."""
    freedom = sum(len(mine) - 1 for mine in values)
    return float(sum(((mine - mine.mean()) ** 2).sum() for mine in values) / freedom) if freedom else 0.0


def _halved(first: Chosen, second: Chosen, keys: Sequence[MomentKey], name: str) -> float:
    """Return the same where half of the repeats are drawn, mean over draws; NaN where that would leave one or none."""
    if min(chosen[key].total() for key in keys for chosen in (first, second)) < 4:
        return np.nan
    rng = stream(0, f"halved:{name}")
    drawn = [
        _within(values_by_seed({key: gap(_half(first[key], rng), _half(second[key], rng)) for key in keys}))
        for _ in range(HALVED)
    ]
    return float(np.mean(drawn))


def _half(counts: Counter[str], rng: Generator) -> Counter[str]:
    taken = rng.multivariate_hypergeometric(list(counts.values()), counts.total() // 2)
    return Counter(dict(zip(counts, taken.tolist(), strict=True)))


def _needed(pilot: Mapping[str, Any], difference: float | None, target: float, level: float) -> dict[str, Any]:
    """Return how many seeds the one-sided sign-flip test needs at a level, and why there is no number."""
    excess = max(pilot["observed"], 0.0) if difference is None else difference
    variances = {
        "n": pilot["sd"] ** 2,
        "n_moments": pilot["between"] + (pilot["by_moments"] + pilot["by_repeats"]) / 2,
        "n_repeats": pilot["between"] + pilot["by_moments"] + pilot["by_repeats"] / 2,
    }
    spreads = np.array([np.sqrt(variance) if variance > 0 else np.nan for variance in variances.values()])
    by_t = pairs_needed(excess / spreads, np.full(3, 2 * level), target)
    fewest = max(int(np.ceil(-np.log2(level))), FEWEST_FOR_CLAIMS)  # signs that all point upwards
    standard = np.array(pilot["excesses"]) - pilot["observed"]
    seeds = [
        _seeds(excess + standard * spread / np.sqrt((standard**2).mean()), level, target, int(max(start, fewest)))
        if not np.isnan(start)
        else np.nan
        for spread, start in zip(spreads, by_t, strict=True)
    ]
    causes = ((np.isnan(pilot["sd"]), NO_PAIRS), (pilot["sd"] == 0, NO_SPREAD), (excess == 0, NO_DIFFERENCE),
              (np.isnan(seeds[0]), TOO_MANY))  # fmt: skip
    note = next((text for holds, text in causes if holds), "")
    return {"difference": excess, **dict(zip(variances, seeds, strict=True)), "note": note}


def _seeds(excesses: FloatArray, level: float, target: float, least: int) -> float:
    """Return the least tried number of seeds, drawn from these excesses, at which the test has the power."""
    for n in (n for n in SIMULATED if n >= least):
        rng = stream(n, "probe power")
        drawn = scaled(excesses[rng.integers(0, len(excesses), size=(RESAMPLES, n))])
        null = drawn @ signs_of_simulations(n, level, rng).T
        p = (np.hstack([null, -null]) >= drawn.sum(axis=1, keepdims=True) - TIES).mean(axis=1)
        if (p <= level).mean() >= target:
            return n
    return max(least, SIMULATED[-1] + 1)
