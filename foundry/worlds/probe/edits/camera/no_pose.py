"""An agent is not told where it is and was, nor where it looks; the image shows what it showed."""

from __future__ import annotations

from foundry.worlds.base import Question
from foundry.worlds.probe.editing import observing

NAME = "no_pose"
LEAVES = "cause"
_POSE = ("x", "y", "z", "yaw", "pitch")


def edit(question: Question) -> Question:
    """Return the question without poses: null in their place."""
    history = tuple({**one, "pose": None} for one in question.observation.get("history", ()))
    return observing(question, **dict.fromkeys(_POSE), history=history)
