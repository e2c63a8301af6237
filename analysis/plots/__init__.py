"""Draws results; computes none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from analysis.plots.saving import png_bytes, settle, styled, svg_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Picture:
    """A figure that can be drawn.

    Attributes:
        name: of its files, without an ending.
        title: a few words.
        caption: what it shows, and how to read it.
        draw: draws it.
        says: its numbers in words, for those who do not see it.
    """

    name: str
    title: str
    caption: str
    draw: Callable[[], Figure]
    says: str = ""


@dataclass(frozen=True)
class Drawn:
    """A picture as it can be written: `png` for print and for what is dense, `svg` for pages."""

    picture: Picture
    png: bytes
    svg: str


def draw(picture: Picture) -> Drawn:
    """Draw a picture in both formats, the same bytes each time."""
    with styled():
        figure = picture.draw()
        settle(figure)
        return Drawn(picture, png_bytes(figure), svg_text(figure, picture.name))


def write(drawn: Drawn, folder: Path) -> list[Path]:
    """Write a picture into a folder; returns the files."""
    folder.mkdir(parents=True, exist_ok=True)
    png, svg = folder / f"{drawn.picture.name}.png", folder / f"{drawn.picture.name}.svg"
    png.write_bytes(drawn.png)
    svg.write_text(drawn.svg, encoding="utf-8", newline="\n")
    return [png, svg]
