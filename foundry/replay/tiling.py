"""Pictures of several runs in one."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence

import numpy as np
from PIL import Image

from foundry.replay.recording import Recording
from foundry.worlds.camera.eye.captions import captioned
from foundry.worlds.camera.loading.scene import UInt8Array

WIDEST = 1920
"""Pixels of a whole row; wider ones are scaled down."""
_CAPTION_PX = 62
"""Height of the band above each picture: two lines of text."""


def captions(recordings: Sequence[Recording]) -> list[str]:
    """Return a line for each run: its model, its seed and whatever else is not the same in all of them."""
    identities = [dict(one.identity) for one in recordings]
    names = list(dict.fromkeys(name for identity in identities for name in identity))
    told = [
        name for name in names if name in ("model", "seed") or len({identity.get(name) for identity in identities}) > 1
    ]
    return [", ".join(_said(name, identity[name]) for name in told if name in identity) for identity in identities]


def _said(name: str, value: str) -> str:
    return value if name == "model" else f"{name} {value}"


def tiled(pictures: Sequence[bytes], texts: Sequence[str]) -> bytes:
    """Return one PNG of several, as many across as down or one more, each with its text above it."""
    columns = math.ceil(math.sqrt(len(pictures)))
    opened = [Image.open(io.BytesIO(picture)).convert("RGB") for picture in pictures]
    width, height = (max(sizes) for sizes in zip(*(picture.size for picture in opened), strict=True))
    scale = min(1.0, WIDEST / (columns * width))
    width, height = math.ceil(width * scale), math.ceil(height * scale)
    rows = math.ceil(len(pictures) / columns)
    sheet = Image.new("RGB", (columns * width, rows * (height + _CAPTION_PX)), "white")
    for number, (picture, text) in enumerate(zip(opened, texts, strict=True)):
        picture.thumbnail((width, height))
        row, column = divmod(number, columns)
        sheet.paste(Image.fromarray(_headed(picture, text)), (column * width, row * (height + _CAPTION_PX)))
    content = io.BytesIO()
    sheet.save(content, "PNG", compress_level=1)
    return content.getvalue()


def _headed(picture: Image.Image, text: str) -> UInt8Array:
    """Return a picture below a band that holds its text."""
    band = np.full((_CAPTION_PX, picture.width, 3), 255, np.uint8)
    return captioned(np.concatenate([band, np.asarray(picture, np.uint8)]), text)
