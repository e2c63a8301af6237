"""An agent exchanges its persona with the first neighbour that has another one."""

from __future__ import annotations

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

NAME = "swap_persona"
LEAVES = "cause"


def edit(question: Question) -> Question | None:
    """Return the question with the two personas exchanged; None where all neighbours are alike, or there are none."""
    own, near = question.observation["persona"], question.observation["neighbours"]
    place = next((number for number, other in enumerate(near) if other["persona"] != own), None)
    if place is None:
        return None
    swapped = [{**other, "persona": own} if number == place else other for number, other in enumerate(near)]
    return observing(question, persona=near[place]["persona"], neighbours=swapped)
