"""The past is taken away: an agent's own memories, and what others said."""

from __future__ import annotations

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

NAME = "no_history"
LEAVES = "cause"


def edit(question: Question) -> Question:
    """Return the question of an agent that remembers nothing and has received nothing."""
    return observing(question, memory=[], received=[])
