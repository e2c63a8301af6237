"""Images that an agent sees, changed and encoded again as they were: PNG or JPEG."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace

from PIL import Image

from foundry.worlds.base import Question

JPEG_QUALITY = 95
"""High, since a JPEG that is encoded a second time loses a little more."""


def seeing(question: Question, change: Callable[[Image.Image], Image.Image]) -> Question | None:
    """Return the question with every image changed; None where there are none."""
    if not question.images:
        return None
    return replace(question, images=tuple(_changed(image, change) for image in question.images))


def _changed(encoded: bytes, change: Callable[[Image.Image], Image.Image]) -> bytes:
    buffer = io.BytesIO()
    with Image.open(io.BytesIO(encoded)) as image:
        change(image).save(buffer, image.format, **({"quality": JPEG_QUALITY} if image.format == "JPEG" else {}))
    return buffer.getvalue()
