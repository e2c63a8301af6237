"""Draws results, but computes none."""

from __future__ import annotations

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
        name: name of its files, without a suffix.
        title: title, in a few words.
        caption: text on its content and how to read it.
        draw: function that draws it.
        says: its numbers in words, for readers who cannot see it.
        data: its data, written as CSV next to it; see `analysis.plots.data.rows_of`.
    """

    name: str
    title: str
    caption: str
    draw: Callable[[], Figure]
    says: str = ""
    data: Sequence[Any] = ()


@dataclass(frozen=True)
class Drawn:
    """A picture in the requested formats; other formats are empty."""

    picture: Picture
    svg: str = ""
    pdf: bytes = b""
    png: bytes = b""


def draw(picture: Picture, *formats: str, columns: int = 1) -> Drawn:
    """Draw a picture in some of `FORMATS`, with equal bytes each time; it is as wide as `columns` of a paper."""
    with styled(columns):
        figure = picture.draw()
        settle(figure)
        # PNG comes first, because the other formats change the figure's points per inch.
        png = png_bytes(figure) if "png" in formats else b""
        pdf = pdf_bytes(figure) if "pdf" in formats else b""
        return Drawn(picture, svg_text(figure, picture.name) if "svg" in formats else "", pdf, png)


def write(drawn: Drawn, folder: Path) -> list[Path]:
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
