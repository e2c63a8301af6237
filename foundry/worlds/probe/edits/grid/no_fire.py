"""The fires that an agent perceives are taken away; what was said or remembered of them stays."""

from __future__ import annotations

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

NAME = "no_fire"
LEAVES = "cause"


def edit(question: Question) -> Question:
    """Return the question of an agent that perceives no fire."""
    window = [row.replace("*", ".") for row in question.observation.get("window", ())]
    return observing(question, fires=[], burning=[], window=window)
