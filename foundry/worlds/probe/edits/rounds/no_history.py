"""The past is taken away: earlier rounds, what was earned in them, and what others said."""

from __future__ import annotations

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

NAME = "no_history"
LEAVES = "cause"
_PAST = ("evenings", "rounds", "months", "memory", "turns", "talk", "received")
_SUMS = ("met", "points", "total")
"""What is counted or summed over the past."""


def edit(question: Question) -> Question:
    """Return the question of an agent that knows of nothing before."""
    return observing(question, **{key: [] for key in _PAST}, **dict.fromkeys(_SUMS, 0))
