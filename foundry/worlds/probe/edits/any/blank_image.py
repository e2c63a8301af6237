"""Nothing is to be seen: every image is one grey."""

from __future__ import annotations

from PIL import Image

from foundry.worlds.base import Question
from foundry.worlds.probe.images import seeing

NAME = "blank_image"
LEAVES = "cause"
_GREY = (128, 128, 128)


def edit(question: Question) -> Question | None:
    """Return the question with grey images of the same sizes; None where there are none."""
    return seeing(question, lambda image: Image.new("RGB", image.size, _GREY))
