"""Reads log-probabilities in replies, which have the same form in OpenAI's and in Ollama's API."""

import math
from collections.abc import Mapping
from typing import Any

from foundry.canary import TokenLogprobs
from foundry.errors import InputError
from foundry.texts import without_surrogates

MOST = 20
"""Maximum number of likeliest tokens that servers report."""


def checked_logprobs(likeliest: int | None) -> int | None:
    """Return the setting `model.logprobs`; raise an error for a value that no server accepts."""
    if likeliest is not None and not (isinstance(likeliest, int) and 1 <= likeliest <= MOST):
        raise InputError(f"model.logprobs must be a number from 1 to {MOST} or null; got {likeliest}.")
    return likeliest


def logprobs_asked(likeliest: int | None) -> dict[str, Any]:
    """Return the fields of a call that ask, for each token, for this number of likeliest tokens; {} for None."""
    return {} if likeliest is None else {"logprobs": True, "top_logprobs": likeliest}


def read_logprobs(value: Any) -> tuple[TokenLogprobs, ...]:
    """Return the tokens that a reply lists; empty if the value is not a list of tokens."""
    tokens = [_token(item) for item in value] if isinstance(value, list) else []
    return () if None in tokens else tuple(token for token in tokens if token is not None)


def _token(item: Any) -> TokenLogprobs | None:
    pair = _pair(item)
    if pair is None:
        return None
    rows = item.get("top_logprobs")
    top = [_pair(row) for row in rows] if isinstance(rows, list) else []
    return TokenLogprobs(*pair, dict(row for row in top if row is not None))


def _pair(item: Any) -> tuple[str, float] | None:
    if not isinstance(item, Mapping):
        return None
    token, logprob = item.get("token"), item.get("logprob")
    if not isinstance(token, str) or isinstance(logprob, bool) or not isinstance(logprob, int | float):
        return None
    return (without_surrogates(token), float(logprob)) if math.isfinite(logprob) else None
