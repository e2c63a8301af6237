"""What others said is taken away; what an agent remembers of it stays."""

from __future__ import annotations

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

NAME = "no_messages"
LEAVES = "cause"


def edit(question: Question) -> Question:
    """Return the question of an agent that has received nothing."""
    return observing(question, received=[])
