"""Replies that decide, for each action that is legal: what scripted policies choose from."""

from __future__ import annotations

import json
from functools import lru_cache

import numpy as np

from foundry.declared import Actions
from foundry.worlds.rounds.reading import ACTION, MESSAGE

MOST_NUMBERS = 1001
"""Whole numbers of a range that are each a reply; a longer range, or one of all numbers, has `SPACED` of them."""
SPACED = 101
SILENCE = json.dumps({MESSAGE: None})


@lru_cache(maxsize=4096)
def options_of(actions: Actions | None) -> tuple[str, ...]:
    """Return a reply for each action, for numbers of a long range for some, evenly; silence where there are none."""
    if actions is None:
        return (SILENCE,)
    return tuple(map(deciding, actions.labels or _numbers(actions)))


@lru_cache(maxsize=4096)
def idle_of(actions: Actions | None) -> str | None:
    """Return the reply that does nothing, or None where none does."""
    if actions is None:
        return SILENCE
    return None if actions.idle is None else deciding(actions.idle)


def deciding(action: str | float) -> str:
    """Return the reply that decides for an action."""
    return json.dumps({ACTION: action}, ensure_ascii=False)


def _numbers(actions: Actions) -> list[float]:
    """Return the numbers of a range; none of one that has no end."""
    if actions.low is None or actions.high is None:
        return []
    if not actions.whole:
        return [float(one) for one in np.linspace(actions.low, actions.high, SPACED)]
    first, last = int(np.ceil(actions.low)), int(np.floor(actions.high))
    if last - first < MOST_NUMBERS:
        return list(range(first, last + 1))
    return sorted({round(one) for one in np.linspace(first, last, SPACED).tolist()})
