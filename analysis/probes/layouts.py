"""Columns and captions of the short tables of a probe."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import pandas as pd

from analysis.tables.table import Table
from analysis.tables.texts import p_value, text_rows


@dataclass(frozen=True)
class Layout:
    """The layout of a short table.

    Attributes:
        labels: columns of names.
        figures: columns of numbers.
        ends: for each column with an interval, the columns with its lower and its upper end.
    """

    caption: str
    labels: tuple[str, ...]
    figures: tuple[str, ...]
    ends: Mapping[str, tuple[str, str]] = field(default_factory=dict)

    def table(self, name: str, frame: pd.DataFrame) -> Table:
        """Convert a table of numbers to a short table of texts."""
        numbers = [figure for figure in self.figures if figure not in (*self.ends, "p_holm")]
        rows = text_rows(frame.assign(p_holm=frame["p_holm"].map(p_value)) if "p_holm" in frame else frame, numbers,
                         self.ends)  # fmt: skip
        columns = (*self.labels, *self.figures)
        heads = tuple("p (Holm)" if column == "p_holm" else column.replace("_", " ") for column in columns)
        return Table(name, self.caption, heads, tuple(tuple(str(row[column]) for column in columns) for row in rows),
                     labels=len(self.labels))  # fmt: skip


LAYOUTS = {
    "edit_choices": Layout(
        "Share of a choice without and with an edit, and its change with a 95 % interval over seeds. For an "
        "equivariance, before holds the expected choices.",
        ("model", "edit", "kind", "choice"),
        ("moments", "before", "after", "change", "p_holm"),
        {"change": ("low", "high")},
    ),
    "format_orders": Layout(
        "Difference between two models in the share of a choice, over all formats. Then the number of formats in "
        "which each model has the larger share, the share of pairs of formats in which the order is reversed, and "
        "the value of this share by chance. The last column counts only formats whose interval over seeds excludes "
        "0.",
        ("first", "second", "kind", "choice"),
        ("difference", "first_more", "second_more", "turned", "floor", "turned_clearly"),
        {"difference": ("low", "high")},
    ),
    "steepness": Layout(
        "Change of the share of a choice per unit of the quantity that varies: slope within moments with its 95 % "
        "interval over seeds.",
        ("model", "quantity", "kind", "choice"),
        ("moments", "seeds", "slope", "p_holm"),
        {"slope": ("low", "high")},
    ),
}
