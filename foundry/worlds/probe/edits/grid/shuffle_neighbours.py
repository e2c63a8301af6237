"""The neighbours are named in another order, drawn for the moment."""

from __future__ import annotations

from foundry import seeding
from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

NAME = "shuffle_neighbours"
LEAVES = "invariance"


def edit(question: Question) -> Question:
    """Return the question with its neighbours in a drawn order, the same each time."""
    near = question.observation["neighbours"]
    order = seeding.stream(question.sampling_seed(0), NAME).permutation(len(near))
    return observing(question, neighbours=[near[place] for place in order.tolist()])
