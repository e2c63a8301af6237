"""What others said is taken away, in conversations too; an agent's own words in them stay."""

from __future__ import annotations

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

NAME = "no_messages"
LEAVES = "cause"


def edit(question: Question) -> Question:
    """Return the question of an agent that has heard nobody else."""
    own = [one for one in question.observation.get("talk", ()) if one["agent"] == question.agent]
    return observing(question, received=[], talk=own)
