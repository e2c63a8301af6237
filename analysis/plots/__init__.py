"""Draws plots of results, but computes none."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from analysis.plots.saving import pdf_bytes, png_bytes, settle, styled, svg_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = ("svg", "pdf", "png")
"""Formats of a picture."""


@dataclass(frozen=True)
class Picture:
    """A figure that can be drawn.

    Attributes:
        says: its numbers in words, for readers who cannot see it.
        data: its data, which is written as CSV; see `analysis.plots.data.rows_of`.
    """

    name: str
    title: str
    caption: str
    draw: Callable[[], Figure]
    says: str = ""
    data: Sequence[Any] = ()


@dataclass(frozen=True)
class DrawnPicture:
    """A picture in the requested formats; the fields of other formats are empty."""

    picture: Picture
    svg: str = ""
    pdf: bytes = b""
    png: bytes = b""


def draw(picture: Picture, *formats: str, columns: int = 1, dense: float = math.inf) -> DrawnPicture:
    """Draw a picture; the same picture always gives the same bytes.

    Args:
        picture: the picture.
        *formats: some of `FORMATS`.
        columns: width of the figure in columns of a paper.
        dense: number of characters of SVG above which the picture is also drawn as PNG.
    """
    with styled(columns):
        figure = picture.draw()
        settle(figure)
        svg = svg_text(figure, picture.name) if "svg" in formats else ""
        pdf = pdf_bytes(figure) if "pdf" in formats else b""
        png = png_bytes(figure) if "png" in formats or len(svg) > dense else b""
        return DrawnPicture(picture, svg, pdf, png)


def write(drawn: DrawnPicture, folder: Path) -> list[Path]:
    """Write a picture and its data into a folder, and return the files."""
    from analysis.plots.data import csv_of

    contents = {
        "svg": drawn.svg.encode(),
        "pdf": drawn.pdf,
        "png": drawn.png,
        "csv": csv_of(drawn.picture.data).encode() if drawn.picture.data else b"",
    }
    folder.mkdir(parents=True, exist_ok=True)
    files = {folder / f"{drawn.picture.name}.{ending}": content for ending, content in contents.items() if content}
    for file, content in files.items():
        file.write_bytes(content)
    return list(files)
