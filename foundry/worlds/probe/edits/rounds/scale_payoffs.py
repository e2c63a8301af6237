"""All points are ten times as many, those of the past too, so that nothing is worth more than before beside the rest.

Where points are what is decided about, as tokens and tons are, nothing changes.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

NAME = "scale_payoffs"
LEAVES = "invariance"
FACTOR = 10
_POINTS = ("fun", "crowded", "home", "equal", "different", "points", "utility")
_PAST = ("evenings", "memory")


def edit(question: Question) -> Question:
    """Return the question with more points for everything."""
    seen = question.observation
    past = {key: [{**one, **_scaled(one)} for one in seen[key]] for key in _PAST if key in seen}
    return observing(question, **_scaled(seen), **past)


def _scaled(told: Mapping[str, Any]) -> dict[str, Any]:
    return {key: told[key] * FACTOR for key in _POINTS if isinstance(told.get(key), int | float)}
