"""Effects of a prompt's format: how far choices spread over formats, and whether formats reverse the order of models.

As in Sclar et al. 2024 (arXiv 2310.11324), the spread of a choice is its largest share in any format minus its least.
The floor is the value expected if formats had no effect: the mean over random redistributions of each moment's answers
among the formats.
"""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd
from numpy.random import Generator

from analysis.arrays import FloatArray, IntArray
from analysis.probes.choices import Answers, Chosen, MomentKey, Subject
from analysis.probes.comparing import excess_of
from analysis.probes.probe_declaring import EVERYTHING, Family
from analysis.stats.intervals import estimate, estimates
from foundry.seeding import stream

DEALT = 199
"""Number of random redistributions of answers among the formats."""
SPREAD = (
    "model", "kind", "choice", "formats", "moments", "seeds", "share", "least", "least_format", "greatest",
    "greatest_format", "spread", "floor", "excess", "excess_low", "excess_high", "p", "sd", "sd_low", "sd_high",
    "g_z", "superiority",
)  # fmt: skip
ORDERS = (
    "first", "second", "kind", "choice", "formats", "moments", "seeds", "difference", "low", "high", "first_more",
    "second_more", "turned", "floor", "turned_clearly",
)  # fmt: skip


@dataclass(frozen=True)
class ChoicesByFormat:
    """A subject's choices in one kind of question, in the moments that were asked in every format.

    Attributes:
        counts: count of each choice (moments, formats, choices); a moment is asked equally often in each format.
        seeds: the seed of each moment (moments,).
    """

    counts: IntArray
    choices: tuple[str, ...]
    seeds: npt.NDArray[np.int64]

    @property
    def asked(self) -> IntArray:
        """Number of times that each moment was asked per format (moments,)."""
        return np.asarray(self.counts[:, 0].sum(axis=1))

    def of(self, choice: str) -> IntArray:
        """Return how often one choice was made in each moment and format, (moments, formats)."""
        if choice not in self.choices:
            return np.zeros(self.counts.shape[:2], dtype=np.int64)
        return self.counts[..., self.choices.index(choice)]

    def by_seed(self, values: FloatArray) -> FloatArray:
        """Return the mean of values (moments, ...) over the moments of each seed, (seeds, ...)."""
        return np.stack([values[self.seeds == seed].mean(axis=0) for seed in np.unique(self.seeds)])


def format_tables(answers: Answers, declared: Family = EVERYTHING) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return two tables: the spread of choices over formats, and how often formats reverse the order of models.

    p is corrected over the rows of declared models; other rows have no `p_holm`.
    """
    several = len(answers.formats) > 1
    kinds = sorted({key.kind for chosen in answers.chosen.values() for key in chosen} if several else ())
    formatted = {
        (subject, kind): of_subject
        for subject in answers.names
        for kind in kinds
        if (of_subject := _formatted(answers, subject, kind)) is not None
    }
    spread = [
        {"model": answers.names[subject], "kind": kind} | row
        for (subject, kind), counts in formatted.items()
        for row in _spread_rows(counts, answers.formats)
    ]
    orders = [
        {"first": answers.names[first], "second": answers.names[second], "kind": kind} | row
        for first, second in itertools.combinations(answers.names, 2)
        for kind in kinds
        if (first, kind) in formatted and (second, kind) in formatted
        for row in _order_rows(formatted[first, kind], formatted[second, kind])
    ]
    frame = pd.DataFrame(spread, columns=list(SPREAD))
    frame.insert(list(SPREAD).index("p") + 1, "p_holm", np.nan)
    declared.correct(frame)
    return frame, pd.DataFrame(orders, columns=list(ORDERS))


def _formatted(answers: Answers, subject: Subject, kind: str) -> ChoicesByFormat | None:
    asked = [answers.of(subject, format=format_name) for format_name in answers.formats]
    keys = sorted(key for key in asked[0] if key.kind == kind and _is_alike(key, asked))
    if not keys:
        return None
    choices = sorted({choice for chosen in asked for key in keys for choice in chosen[key]})
    counts = [[[chosen[key][choice] for choice in choices] for chosen in asked] for key in keys]
    return ChoicesByFormat(np.array(counts, dtype=np.int64), tuple(choices), np.array([key.seed for key in keys]))


def _is_alike(key: MomentKey, asked: Sequence[Chosen]) -> bool:
    return all(key in chosen and chosen[key].total() == asked[0][key].total() for chosen in asked)


def _spread_rows(formatted: ChoicesByFormat, formats: Sequence[str]) -> Iterator[dict[str, Any]]:
    for choice in formatted.choices:
        counts = formatted.of(choice)
        shares = formatted.by_seed(counts / formatted.asked[:, None])
        dealt = _by_seed_dealt(formatted, counts, stream(0, f"formats:{choice}"))
        spread, floor = np.ptp(shares, axis=1), np.ptp(dealt, axis=2)
        overall = shares.mean(axis=0)
        variance = estimate(shares.var(axis=1, ddof=1) - _variance_by_chance(formatted, counts))
        ends = [variance.mean, variance.low, variance.high]
        least, greatest = int(overall.argmin()), int(overall.argmax())
        yield {
            "choice": choice,
            "formats": len(formats),
            "moments": len(counts),
            "seeds": len(shares),
            "share": overall.mean(),
            "least": overall[least],
            "least_format": formats[least],
            "greatest": overall[greatest],
            "greatest_format": formats[greatest],
            "spread": spread.mean(),
            "floor": floor.mean(),
            **excess_of(spread - floor.mean(axis=0)),
            **dict(zip(("sd", "sd_low", "sd_high"), np.sqrt(np.maximum(ends, 0.0)).tolist(), strict=True)),
        }


def _dealt(counts: IntArray, asked: IntArray, rng: Generator) -> IntArray:
    """Deal the answers of each moment to the formats at random, again and again.

    Args:
        counts: how often a choice was made, (moments, formats).
        asked: number of answers of each moment in each format, (moments,).
        rng: the random generator.

    Returns:
        How often the choice was made after each draw, (draws, moments, formats).
    """
    formats = counts.shape[1]
    left = np.broadcast_to(counts.sum(axis=1), (DEALT, len(counts)))
    drawn = []
    for after in range(formats - 1, -1, -1):
        drawn.append(rng.hypergeometric(left, asked * (after + 1) - left, asked) if after else left)
        left = left - drawn[-1]
    return np.stack(drawn, axis=-1)


def _by_seed_dealt(formatted: ChoicesByFormat, counts: IntArray, rng: Generator) -> FloatArray:
    """Deal the answers of each moment to the formats at random, again and again.

    Return the mean share of a choice for each draw, seed and format, (draws, seeds, formats).
    """
    shares = _dealt(counts, formatted.asked, rng) / formatted.asked[:, None]
    return np.moveaxis(formatted.by_seed(np.moveaxis(shares, 0, 1)), 1, 0)


def _variance_by_chance(formatted: ChoicesByFormat, counts: IntArray) -> FloatArray:
    """Return for each seed how much the share of a choice would vary between formats by chance alone, (seeds,).

    Let k of the F n answers in a moment be a given choice, and p = k / F n. The counts in the formats are
    hypergeometric, with variance n p (1 - p) (F n - n) / (F n - 1), and a covariance of -1 / (F - 1) times this
    variance. So their sample variance has the mean n^2 F p (1 - p) / (F n - 1). The moments of a seed are independent.
    """
    formats, asked = counts.shape[1], formatted.asked
    share = counts.mean(axis=1) / asked
    by_moment = formats * share * (1 - share) / np.maximum(formats * asked - 1, 1)
    _, moments = np.unique(formatted.seeds, return_counts=True)
    return formatted.by_seed(by_moment) / moments


def _order_rows(first: ChoicesByFormat, second: ChoicesByFormat) -> Iterator[dict[str, Any]]:
    seeds = np.intersect1d(first.seeds, second.seeds)
    for choice in dict.fromkeys([*first.choices, *second.choices]):
        pair = [
            (formatted, formatted.of(choice), np.isin(np.unique(formatted.seeds), seeds))
            for formatted in (first, second)
        ]
        shares = [formatted.by_seed(counts / formatted.asked[:, None])[rows] for formatted, counts, rows in pair]
        difference = shares[0] - shares[1]
        rng = stream(0, f"format orders:{choice}")
        dealt = [_by_seed_dealt(formatted, counts, rng)[:, rows] for formatted, counts, rows in pair]
        null = (dealt[0] - dealt[1]).mean(axis=1)
        over_seeds, each = (
            estimate(difference.mean(axis=1), -1.0, 1.0),
            estimates(difference.T, np.full(difference.shape[1], -1.0), np.full(difference.shape[1], 1.0)),
        )
        sure = np.where(each.low > 0, 1, np.where(each.high < 0, -1, 0))
        yield {
            "choice": choice,
            "formats": difference.shape[1],
            "moments": len(first.counts),
            "seeds": len(seeds),
            "difference": over_seeds.mean,
            "low": over_seeds.low,
            "high": over_seeds.high,
            "first_more": int((_signs(each.mean) > 0).sum()),
            "second_more": int((_signs(each.mean) < 0).sum()),
            "turned": float(_turned(_signs(each.mean)[None, :])[0]),
            "floor": float(_turned(_signs(null)).mean()),
            "turned_clearly": float(_turned(sure[None, :])[0]),
        }


def _signs(values: FloatArray) -> IntArray:
    return np.where(np.abs(values) < 1e-12, 0, np.sign(values)).astype(np.int64)


def _turned(signs: IntArray) -> FloatArray:
    """Return for each row of signs (rows, formats) the share of pairs of formats that have opposite signs, (rows,)."""
    formats = signs.shape[1]
    more, less = (signs > 0).sum(axis=1), (signs < 0).sum(axis=1)
    return np.asarray(more * less / (formats * (formats - 1) / 2), dtype=np.float64)
