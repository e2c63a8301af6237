"""Tables for a page, with links in their cells."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from analysis.tables.table import Table


@dataclass(frozen=True)
class Cell:
    """A text with an optional link."""

    text: str
    href: str = ""


@dataclass(frozen=True)
class Grid:
    """A table of the page.

    Attributes:
        labels: number of columns, from the left, that contain names instead of numbers.
    """

    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    labels: int = 1


def grid(caption: str, columns: Sequence[str], rows: Iterable[Sequence[object]], labels: int = 1) -> Grid:
    """Return a table; a value that is no `Cell` is shown as text without a link."""
    cells = (tuple(content if isinstance(content, Cell) else Cell(str(content)) for content in row) for row in rows)
    return Grid(caption, tuple(columns), tuple(cells), labels)


def grid_of(table: Table) -> Grid:
    """Convert a table of texts to a table of the page."""
    return grid(table.caption, table.columns, table.rows, table.labels)
