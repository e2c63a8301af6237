"""The images are those of another moment, as if the agent saw what was seen then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import drawn

NAME = "other_image"
LEAVES = "cause"


def edit(question: Question, others: Sequence[Question]) -> Question | None:
    """Return the question with the images of another one of its kind; None where all see the same."""
    seen = [one.images for one in others if one.kind == question.kind]
    found = drawn(question, NAME, [one for one in seen if one != question.images and len(one) == len(question.images)])
    return None if found is None else replace(question, images=found)
