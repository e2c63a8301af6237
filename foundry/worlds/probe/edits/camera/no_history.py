"""The past is taken away: earlier decisions and what came of them."""

from __future__ import annotations

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

NAME = "no_history"
LEAVES = "cause"


def edit(question: Question) -> Question:
    """Return the question of an agent that has decided nothing before."""
    return observing(question, history=(), idle_streak=0)
