"""Puts the pictures of several runs side by side."""

import io
import math
from collections.abc import Sequence
from dataclasses import dataclass

from PIL import Image

from foundry.replay.recording import Recording
from foundry.replay.telling import band, band_height, in_lines
from foundry.worlds.camera.eye.overview import MARGIN_PX, PAPER

WIDEST = 1920
"""Maximum width of a row, pixels; wider rows are scaled down."""
_HEAD = 2
"""Number of lines of text above each picture."""


def captions(recordings: Sequence[Recording]) -> list[str]:
    """Return a caption for each run: its model, its seed, and the other settings in which the runs differ."""
    identities = [dict(recording.identity) for recording in recordings]
    names = list(dict.fromkeys(name for identity in identities for name in identity))
    lines = [
        name for name in names if name in ("model", "seed") or len({identity.get(name) for identity in identities}) > 1
    ]
    return [", ".join(_label(name, identity[name]) for name in lines if name in identity) for identity in identities]


def _label(name: str, value: str) -> str:
    return value if name == "model" else f"{name} {value}"


@dataclass(frozen=True)
class Tile:
    """One run's tile in a picture with several runs: a PNG, the text above it, and the messages below it."""

    picture: bytes
    text: str
    said: Sequence[str] = ()


def tiled(tiles: Sequence[Tile], *, room: tuple[int, int] | None = None, lines: int = 0) -> bytes:
    """Return a PNG with the tiles in rows and columns, about as many rows as columns.

    Args:
        tiles: the tiles.
        room: width and height in pixels to which larger pictures are scaled down; None for the largest picture.
        lines: number of lines of messages below each picture.
    """
    columns = math.ceil(math.sqrt(len(tiles)))
    opened = [Image.open(io.BytesIO(tile.picture)).convert("RGB") for tile in tiles]
    width, height = room or largest(opened)
    scale = min(1.0, WIDEST / (columns * width))
    width, height = math.ceil(width * scale), math.ceil(height * scale)
    above, below, across = band_height(_HEAD), band_height(lines), width - 2 * MARGIN_PX
    whole = above + height + below
    sheet = Image.new("RGB", (columns * width, math.ceil(len(tiles) / columns) * whole), PAPER)
    for number, (picture, tile) in enumerate(zip(opened, tiles, strict=True)):
        picture.thumbnail((width, height))
        left, top = number % columns * width, number // columns * whole
        sheet.paste(band(in_lines([tile.text], across, _HEAD), width, _HEAD), (left, top))
        sheet.paste(picture, (left + (width - picture.width) // 2, top + above))
        sheet.paste(band(in_lines(tile.said, across, lines), width, lines), (left, top + whole - below))
    content = io.BytesIO()
    sheet.save(content, "PNG", compress_level=1)
    return content.getvalue()


def largest(opened: Sequence[Image.Image]) -> tuple[int, int]:
    """Return the largest width and the largest height of the pictures, in pixels."""
    return max(image.width for image in opened), max(image.height for image in opened)
