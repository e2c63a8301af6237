"""The canary of a server: its answers to a fixed set of short, greedy calls, which identify its weights.

`foundry/models/wrappers/canaries.py` makes the calls of a canary; this module compares the answers of two canaries.
"""

import hashlib
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from statistics import fmean

import msgspec

PROMPTS = (
    "Write one sentence about a lighthouse keeper.",
    "Name an animal, a colour and a number.",
    "Continue this list: monday, blue, seven, violin,",
    "How do you feel about rain?",
)
TOKENS = 16
"""Length of each reply, tokens."""
LIKELIEST = 5
"""Number of log-probabilities per token."""
PLACES = 4
"""Number of first tokens of a reply whose log-probabilities are compared."""
MARK = "~"
"""If a server changes its weights but not its digest, foundry adds to the digest this sign and a new mark."""
DIGITS = 4
"""Decimals of the recorded log-probabilities."""
SAME_GAP, OTHER_GAP = 0.03, 0.5
"""Two thresholds for the mean difference of log-probabilities between two canaries.

If the difference is at most the first threshold, the weights count as the same; if above the second, as different.
"""
SAME_SHARED, OTHER_SHARED = 0.8, 0.4
"""Two thresholds for the share of the likeliest tokens that two canaries have in common.

If the share is at least the first threshold, the weights count as the same; if below the second, as different.
"""
SAME_TEXT, OTHER_TEXT = 0.75, 0.1
"""Two thresholds for servers without log-probabilities, for the share of a reply before it first differs from another.

If the share is at least the first threshold, the weights count as the same; if below the second, as different. The
script `benchmarks/bench_llama.py` measures all six thresholds; docs/models.md shows the results.
"""


class Verdict(StrEnum):
    """The verdict on two canaries: do they come from the same weights?"""

    SAME = "same"
    UNDECIDED = "undecided"
    OTHER = "other"


class TokenLogprobs(msgspec.Struct, frozen=True):
    """A token of a reply, with its log-probability.

    Attributes:
        logprob: natural logarithm of the token's probability.
        top: log-probabilities of the likeliest tokens at this position, by token.
    """

    token: str
    logprob: float
    top: dict[str, float]


class Sign(msgspec.Struct, frozen=True, kw_only=True):
    """The reply to one prompt of a canary.

    Attributes:
        text: the thinking and the reply.
        tokens: the first tokens of the reply; empty if the server reports none.
    """

    text: str
    tokens: tuple[TokenLogprobs, ...] = ()

    @classmethod
    def of(cls, text: str, tokens: Sequence[TokenLogprobs]) -> "Sign":
        """Return the text and the first tokens of a reply; foundry records these."""
        return cls(text=text, tokens=tuple(map(_rounded, tokens[:PLACES])))


class Canary(msgspec.Struct, frozen=True, kw_only=True):
    """The record of a run about the weights that gave its answers (`canaries` in `run.json`).

    Attributes:
        signs: canary of the weights that gave the cached answers, in the order of the prompts.
        calls: canary calls of the run's worker until the run ended; 0 if all answers came from the cache.
        verdict: worst verdict when these calls were compared with `signs`; null without calls.
        distance: the distance that led to the verdict, in words.
    """

    model: str
    signs: tuple[Sign, ...]
    calls: int = 0
    verdict: Verdict | None = None
    distance: str = ""

    @property
    def short(self) -> str:
        """A short hash of the texts of the replies."""
        return short_of(self.signs)


@dataclass(frozen=True)
class Distance:
    """The distance between two canaries.

    Attributes:
        gap: mean difference of the log-probabilities of tokens that both list; None if not reported.
        shared: share of the likeliest tokens that both list, 0 to 1; None if not reported.
        text: length of the common beginning of two texts, divided by the length of the longer one, as a mean over the
            prompts, 0 to 1; None if one text is always empty.
    """

    gap: float | None
    shared: float | None
    text: float | None

    @classmethod
    def between(cls, first: Sequence[Sign], second: Sequence[Sign]) -> "Distance":
        """Measure the distance between replies to the same prompts, from their tokens up to the first that differs."""
        pairs = list(zip(first, second, strict=True))
        places = [place for sign, other in pairs for place in _same_context(sign.tokens, other.tokens)]
        gaps = [abs(here.top[token] - other.top[token]) for here, other in places for token in _shared(here, other)]
        shares = [len(_shared(here, other)) / max(len(here.top), len(other.top)) for here, other in places]
        texts = [_common_share(sign.text, other.text) for sign, other in pairs if sign.text and other.text]
        return cls(_mean(gaps), _mean(shares), _mean(texts))

    @property
    def order(self) -> tuple[int, float, float]:
        """Key for sorting distances; a larger key makes different weights more likely."""
        return list(Verdict).index(self.verdict), self.gap or 0.0, -(self.text or 0.0)

    @property
    def verdict(self) -> Verdict:
        """The verdict on the weights: from log-probabilities or, if none are reported, from the texts."""
        if self.shared is None:
            return Verdict.UNDECIDED if self.text is None else _judged(self.text, SAME_TEXT, OTHER_TEXT)
        by_shared = _judged(self.shared, SAME_SHARED, OTHER_SHARED)
        by_gap = Verdict.OTHER if self.gap is None else _judged(-self.gap, -SAME_GAP, -OTHER_GAP)
        return max(by_shared, by_gap, key=list(Verdict).index)

    def __str__(self) -> str:
        if self.shared is None:
            return "nothing to compare" if self.text is None else f"{self.text:.0%} of the texts in common"
        apart = "" if self.gap is None else f", log-probabilities {self.gap:.3g} apart"
        return f"{self.shared:.0%} of the likeliest tokens in common{apart}"


def listed(digest: str) -> str:
    """Return the digest that the server reports, without the mark that foundry adds for changed weights."""
    return digest.partition(MARK)[0]


def short_of(signs: Sequence[Sign]) -> str:
    """Return a short hash of the texts of a canary."""
    return hashlib.sha256(msgspec.json.encode([sign.text for sign in signs])).hexdigest()[:8]


def _rounded(place: TokenLogprobs) -> TokenLogprobs:
    top = {token: round(logprob, DIGITS) for token, logprob in place.top.items()}
    return TokenLogprobs(place.token, round(place.logprob, DIGITS), top)


def _judged(value: float, same_from: float, other_below: float) -> Verdict:
    return Verdict.SAME if value >= same_from else Verdict.OTHER if value < other_below else Verdict.UNDECIDED


def _same_context(
    first: Sequence[TokenLogprobs], second: Sequence[TokenLogprobs]
) -> Iterator[tuple[TokenLogprobs, TokenLogprobs]]:
    """Yield the pairs of tokens at the same position in two replies, up to the first pair that differs."""
    for first_token, other in zip(first, second, strict=False):
        if first_token.top and other.top:
            yield first_token, other
        if first_token.token != other.token:
            return


def _shared(mine: TokenLogprobs, other: TokenLogprobs) -> set[str]:
    return mine.top.keys() & other.top.keys()


def _common_share(first: str, second: str) -> float:
    return len(os.path.commonprefix([first, second])) / max(len(first), len(second))


def _mean(values: Sequence[float]) -> float | None:
    return fmean(values) if values else None
