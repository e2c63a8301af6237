"""Text and pictures in pictures, with fonts that are the same on every machine."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from foundry.worlds.camera.loading.scene import UInt8Array

_INK, _PAPER, _FRAME = (20, 24, 32), (255, 255, 255), (20, 24, 32)
_TEXT_PX, _MARGIN_PX, _FRAME_PX = 18, 12, 2
_MOST_LINES = 4


def captioned(image: UInt8Array, text: str) -> UInt8Array:
    """Return the picture with the text in a band along its top; what is too long ends in an ellipsis."""
    lines = list(_wrapped(text, image.shape[1] - 2 * _MARGIN_PX))
    if len(lines) > _MOST_LINES:
        lines = [*lines[: _MOST_LINES - 1], lines[_MOST_LINES - 1] + " …"]
    if not lines:
        return image
    picture = Image.fromarray(image)
    pen, height = ImageDraw.Draw(picture), round(_TEXT_PX * 1.35)
    pen.rectangle((0, 0, picture.width, height * len(lines) + _MARGIN_PX), fill=_PAPER)
    for number, line in enumerate(lines):
        pen.text((_MARGIN_PX, _MARGIN_PX // 2 + number * height), line, fill=_INK, font=_font())
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
def _font() -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf", _TEXT_PX)


def _wrapped(text: str, width: int) -> Iterator[str]:
    for paragraph in text.splitlines():
        line = ""
        for word in paragraph.split():
            longer = f"{line} {word}".lstrip()
            if line and _font().getlength(longer) > width:
                yield line
                longer = word
            line = longer
        yield line
