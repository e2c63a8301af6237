"""Nobody is anyone in particular: an agent's persona is taken away, and those of the neighbours it sees."""

from __future__ import annotations

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

NAME = "no_persona"
LEAVES = "cause"


def edit(question: Question) -> Question:
    """Return the question of an agent without a persona among others without any."""
    near, seen = (
        [{**other, "persona": {}} for other in question.observation.get(key, ())] for key in ("neighbours", "seen")
    )
    return observing(question, persona={}, neighbours=near, seen=seen)
