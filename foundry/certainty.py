"""Computes from log-probabilities how certain a model was of a decision, and how often it would decide each way.

Servers of llama.cpp, vLLM and Ollama report the model's log-probabilities before temperature, filters and grammar. The
class `Sampling` converts log-probabilities to the probabilities of decisions. A server may filter tokens before or
after it applies the temperature, and may have filters that no request named. foundry computes the probabilities for
each such way to filter; the differences between the ways are a part of the error.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from foundry.canary import TokenLogprobs

LEAST_COVERED = 0.95
"""A decision counts only if the probabilities of all labels add up to at least this value."""
GREATEST_ERROR = 1 - LEAST_COVERED
"""Maximum accepted error (total variation, 0..1) of shares that are computed from the probabilities of one reply."""
OPEN = {"top_k": 0, "top_p": 1.0, "min_p": 0.0}
"""Filters that remove no token."""
STRICTEST = {"top_k": 20, "top_p": 0.8, "min_p": 0.05}
"""The strictest default filters of llama.cpp, Ollama and vLLM; vLLM reads its defaults from the files of a model."""
NEUTRAL = {
    "presence_penalty": 0, "frequency_penalty": 0, "repeat_penalty": 1, "repetition_penalty": 1, "typical_p": 1,
    "logit_bias": {}, "mirostat": 0, "xtc_probability": 0, "dry_multiplier": 0, "top_n_sigma": -1,
}  # fmt: skip
"""Options whose effect on probabilities cannot be computed here, each with the value that has no effect."""
Shares: TypeAlias = dict[str, float]


@dataclass(frozen=True)
class Sampling:
    """The rule by which a server draws a token, given the probabilities of all tokens.

    Attributes:
        temperature: 0..1; above 1, the tokens that are not reported could have any share.
        filters: values of `top_k`, `top_p` and `min_p`. There are two, open and strict, if the request leaves one to
            the server.
    """

    temperature: float
    filters: tuple[Mapping[str, float], ...]

    @classmethod
    def of(cls, parameters: Mapping[str, Any]) -> "Sampling | None":
        """Return the rule by which a server draws tokens in a call with these parameters; None if it is unknown."""
        options = {**parameters, **(parameters.get("options") or {})}
        temperature = options.get("temperature")
        is_neutral = all(options.get(name) in (None, value) for name, value in NEUTRAL.items())
        if not isinstance(temperature, int | float) or not 0 <= temperature <= 1 or not is_neutral:
            return None
        named = {name: options[name] for name in OPEN if options.get(name) is not None}
        ways = ({**OPEN, **named}, {**STRICTEST, **named})
        return cls(float(temperature), ways if ways[0] != ways[1] else ways[:1])

    def ways(self, place: TokenLogprobs) -> Iterator[Shares]:
        """Yield the probabilities of the reported tokens at a position, once for each way in which a server may filter.

        The values are lower bounds; all tokens that are not reported have together at most the rest up to 1.
        """
        by_probability = sorted({place.token: place.logprob, **place.top}.items(), key=lambda item: -item[1])
        plain = [math.exp(logprob) for _, logprob in by_probability]
        plain.append(max(0.0, 1 - math.fsum(plain)))
        names = [token for token, _ in by_probability]
        for filters in self.filters if plain[0] else ():
            for chances in (_cut(self._tempered(plain), filters), self._tempered(_cut(plain, filters))):
                yield dict(zip(names, chances, strict=False))

    def _tempered(self, chances: Sequence[float]) -> list[float]:
        """Apply the temperature to probabilities; the last value in `chances` belongs to all unreported tokens.

        No unreported token is likelier than the last reported token. So the last result is an upper bound.
        """
        *listed, rest = chances
        if not self.temperature:
            return [1.0, *([0.0] * len(listed))]
        power = 1 / self.temperature
        weights = [(chance / listed[0]) ** power for chance in listed]
        last = min((chance for chance in listed if chance), default=0.0)
        return _scaled([*weights, rest / listed[0] * (last / listed[0]) ** (power - 1)])


def _cut(chances: Sequence[float], filters: Mapping[str, float]) -> list[float]:
    """Set the probabilities of filtered tokens to 0. The last value in `chances` belongs to all unreported tokens."""
    *listed, rest = chances
    if 0 < filters["top_k"] <= len(listed):
        listed, rest = listed[: int(filters["top_k"])], 0.0
    *listed, rest = _scaled([*listed, rest])
    total = 0.0
    for number, chance in enumerate(listed, start=1):
        total += chance
        if filters["top_p"] < 1 and total >= filters["top_p"]:
            listed, rest = listed[:number], 0.0
            break
    left = [chance for chance in listed if chance >= filters["min_p"] * listed[0]]
    scaled = _scaled([*left, rest if len(left) == len(listed) else 0.0])
    return [*scaled[:-1], *([0.0] * (len(chances) - len(scaled))), scaled[-1]]


def _scaled(weights: Sequence[float]) -> list[float]:
    total = math.fsum(weights)
    return [weight / total for weight in weights]


@dataclass(frozen=True)
class Certainty:
    """Certainty of a decision, from the tokens of its reply.

    Attributes:
        decided: the chosen label.
        shares: the model's probability of each label, scaled to the sum 1.
        covered: sum of the model's probabilities of the labels before scaling, 0..1.
        expected: share of each label that is expected if the call is repeated with its settings, 0..1.
        error: largest possible total variation between the expected and the true shares, 0..1; 1 if nothing is known.
    """

    decided: str
    shares: Shares
    covered: float
    expected: Shares
    error: float

    @property
    def probability(self) -> float:
        """The probability of the chosen label, 0..1; the probabilities of all labels add up to 1."""
        return self.shares[self.decided]

    @property
    def entropy(self) -> float:
        """The entropy of the probabilities of the labels, bits."""
        return max(0.0, -math.fsum(share * math.log2(share) for share in self.shares.values() if share))


def certainty_of(
    text: str,
    tokens: Sequence[TokenLogprobs],
    decided: str,
    labels: Sequence[str],
    sampling: Sampling | None = None,
) -> Certainty | None:
    """Return how certain the decision in a reply was; None if no single token decides.

    Args:
        text: the reply.
        tokens: tokens of the reply.
        decided: the label that the world read from the reply.
        labels: all possible labels.
        sampling: how the server draws tokens; None if unknown.
    """
    place = _place(text, tokens, decided)
    return None if place is None else _certainty_at(place, tokens, decided, labels, sampling)


def _certainty_at(
    place: tuple[int, str],
    tokens: Sequence[TokenLogprobs],
    decided: str,
    labels: Sequence[str],
    sampling: Sampling | None,
) -> Certainty | None:
    number, before = place
    token = tokens[number]
    own = {token.token: token.logprob, **token.top}
    shares = _of_labels(before, {text: math.exp(logprob) for text, logprob in own.items()}, labels)
    covered = math.fsum(shares.values())
    if not shares[decided]:
        return None
    ways = [_of_labels(before, chances, labels) for chances in sampling.ways(token)] if sampling else []
    expected = [_among(way) for way in ways]
    error = 1.0
    if ways and all(expected):
        spread = max(_apart(expected[0], other) for other in expected)
        error = min(1.0, 1 - min(math.fsum(way.values()) for way in ways) + spread)
    return Certainty(decided, _among(shares), min(1.0, covered), expected[0] if expected else {}, max(0.0, error))


def foreseen(
    text: str, tokens: Sequence[TokenLogprobs], decided: str, labels: Sequence[str], sampling: Sampling | None
) -> Certainty | None:
    """Compute from one reply how often a model would give each decision; return None if that is too uncertain.

    The text before the decision must be almost certain: after random words, such as a reason, the probabilities hold
    only for these words. The error of the result holds for all replies.
    """
    place = _place(text, tokens, decided)
    if place is None or sampling is None:
        return None
    certainty = _certainty_at(place, tokens, decided, labels, sampling)
    if certainty is None or certainty.error > GREATEST_ERROR:
        return None
    certain = 1 - certainty.error
    for token in tokens[: place[0]]:
        certain *= min((way[token.token] for way in sampling.ways(token)), default=0.0)
        if certain < LEAST_COVERED:
            return None
    return replace(certainty, error=1 - certain)


def _place(text: str, tokens: Sequence[TokenLogprobs], decided: str) -> tuple[int, str] | None:
    """Return the index of the token in which a decision begins, and the text of this token before the decision.

    The decision must occur in the text exactly once.
    """
    whole = "".join(token.token for token in tokens)
    quoted = f'"{decided}"'
    at = text.find(quoted) + 1 if text.count(quoted) == 1 else text.find(decided)
    shift = whole.find(text)
    if shift < 0 or at < 0 or (text.count(quoted) != 1 and text.count(decided) != 1):
        return None
    at, begin = at + shift, 0
    for number, token in enumerate(tokens):
        if at < begin + len(token.token):
            return number, token.token[: at - begin]
        begin += len(token.token)
    return None


def _of_labels(before: str, chances: Mapping[str, float], labels: Sequence[str]) -> Shares:
    """Return the probability of each label: the summed probabilities of tokens with which only this label begins."""
    shares = dict.fromkeys(labels, 0.0)
    for token, chance in chances.items():
        rest = token.removeprefix(before)
        begun = [label for label in labels if label.startswith(rest) or _is_followed(rest, label)]
        if token.startswith(before) and rest and len(begun) == 1:
            shares[begun[0]] += chance
    return shares


def _is_followed(rest: str, label: str) -> bool:
    """Return whether a token contains a whole label and then a punctuation mark or blank, such as `go"`."""
    return rest.startswith(label) and not rest[len(label)].isalnum()


def _among(shares: Shares) -> Shares:
    total = math.fsum(shares.values())
    return {label: share / total for label, share in shares.items()} if total else {}


def _apart(first: Shares, second: Shares) -> float:
    """Return the total variation distance, 0..1, of two distributions over the same labels."""
    return 0.5 * math.fsum(abs(share - second[label]) for label, share in first.items())
