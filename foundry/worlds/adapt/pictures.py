"""Pixels of an environment as a PNG."""

from __future__ import annotations

import io
from typing import Any

import numpy as np


def as_png(pixels: Any) -> bytes:
    """Return pixels, (height, width, 3), as a PNG; the same pixels give the same bytes."""
    from PIL import Image

    content = io.BytesIO()
    Image.fromarray(np.asarray(pixels, dtype=np.uint8)).save(content, format="PNG")
    return content.getvalue()
