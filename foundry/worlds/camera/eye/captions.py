"""Text and pictures in pictures, with fonts that are the same on every machine."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from foundry.worlds.camera.loading.scene import UInt8Array

INK, PAPER, _FRAME = (20, 24, 32), (255, 255, 255), (20, 24, 32)
MARGIN_PX, LINE_PX = 12, 24
TEXT_PX, _FRAME_PX = 18, 2
_MOST_LINES = 4


def captioned(image: UInt8Array, text: str) -> UInt8Array:
    """Return the picture with the text in a band along its top; what is too long ends in an ellipsis."""
    lines = list(_wrapped(text, image.shape[1] - 2 * MARGIN_PX))
    if len(lines) > _MOST_LINES:
        lines = [*lines[: _MOST_LINES - 1], lines[_MOST_LINES - 1] + " …"]
    if not lines:
        return image
    picture = Image.fromarray(image)
    pen = ImageDraw.Draw(picture)
    pen.rectangle((0, 0, picture.width, LINE_PX * len(lines) + MARGIN_PX), fill=PAPER)
    for number, line in enumerate(lines):
        pen.text((MARGIN_PX, MARGIN_PX // 2 + number * LINE_PX), line, fill=INK, font=font())
    return np.asarray(picture, np.uint8)


def inset_size(inset: UInt8Array, width: int) -> tuple[int, int]:
    """Return the width and height, pixels, of an (h, w, 3) picture that is scaled to a width."""
    return width, round(inset.shape[0] * width / inset.shape[1])


def with_inset(image: UInt8Array, inset: UInt8Array, width: int, place: tuple[int, int]) -> UInt8Array:
    """Return the picture with another one, scaled to this width and framed, from a place (left, top) on."""
    width, height = inset_size(inset, width)
    small = Image.fromarray(inset).resize((width, height), Image.Resampling.LANCZOS)
    picture = Image.fromarray(image)
    left, top = place
    frame = (left - _FRAME_PX, top - _FRAME_PX, left + width + _FRAME_PX - 1, top + height + _FRAME_PX - 1)
    ImageDraw.Draw(picture).rectangle(frame, fill=_FRAME)
    picture.paste(small, (left, top))
    return np.asarray(picture, np.uint8)


@cache
def font() -> ImageFont.FreeTypeFont:
    """Return the font of captions."""
    return ImageFont.truetype(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf", TEXT_PX)


def _wrapped(text: str, width: int) -> Iterator[str]:
    for paragraph in text.splitlines():
        line = ""
        for word in paragraph.split():
            longer = f"{line} {word}".lstrip()
            if line and font().getlength(longer) > width:
                yield line
                longer = word
            line = longer
        yield line
