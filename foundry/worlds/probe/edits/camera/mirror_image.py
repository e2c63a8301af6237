"""Left and right are exchanged in every image; what is told in words, and where the agent is, stays."""

from __future__ import annotations

from typing import Any

from PIL import ImageOps

from foundry.worlds.base import Question
from foundry.worlds.probe.images import seeing

NAME = "mirror_image"
LEAVES = "equivariance"
_SIDES = {"left": "right", "right": "left", "turn left": "turn right", "turn right": "turn left"}


def edit(question: Question) -> Question | None:
    """Return the question with mirrored images; None where there are none."""
    return seeing(question, ImageOps.mirror)


def expected(action: Any) -> Any:
    """Return the action on the other side; all others are what they were."""
    return _SIDES.get(action, action)
