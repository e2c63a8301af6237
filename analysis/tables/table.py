"""A table of texts, for terminals, Markdown and LaTeX."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Table:
    """A table of texts: the first `labels` columns contain names, all further columns contain numbers."""

    name: str
    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    labels: int = 1
