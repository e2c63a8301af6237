"""The style of plots, which readers with colour-vision deficiencies can read in print, in one column of a paper."""

from typing import Any

from foundry.palette import look
from foundry.palette.fonts import families

FAINT, DARK = "#BBBBBB", "#444444"
FIRE, PLACE = "#D55E00", "#555566"

WIDTHS_IN = {1: 3.4, 2: 7.0}
"""Width of a figure over one column and over two columns of a paper, inches."""

DPI = 300

RC: Any = {
    "font.size": 7.5,
    "axes.titley": 1.0,
    "axes.titlesize": 8,
    "axes.titlelocation": "left",
    "axes.labelsize": 7.5,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.spines.left": False,
    "axes.edgecolor": "#666666",
    "axes.linewidth": 0.6,
    "axes.grid": True,
    "axes.grid.axis": "x",
    "axes.axisbelow": True,
    "grid.color": "#E3E3E3",
    "grid.linewidth": 0.6,
    "xtick.major.size": 2.5,
    "xtick.color": DARK,
    "ytick.color": DARK,
    "ytick.major.size": 0,
    "text.parse_math": False,
    "svg.hashsalt": "foundry",
    "svg.fonttype": "none",
    "pdf.fonttype": 42,
}
"""Settings of matplotlib for all plots; the user's own settings are ignored."""


def colour(index: int, *, baseline: bool = False) -> str:
    """Return the colour of the group with this index."""
    return look(index, baseline=baseline).colour


def marker(index: int, *, baseline: bool = False) -> Any:
    """Return the marker of the group with this index."""
    return look(index, baseline=baseline).marker or "o"


def line(index: int, *, baseline: bool = False) -> Any:
    """Return the line style of the group with this index; styles differ even without colour."""
    shown = look(index, baseline=baseline)
    return {
        "color": shown.colour,
        "linestyle": (0, shown.dashes) if shown.dashes else "-",
        "marker": shown.marker or "",
        "markersize": 3.5,
        "markevery": (0.03 + 0.02 * (index % 5), 0.2),
        "zorder": 1.9 if baseline else 2,
    }


def settings(columns: int) -> Any:
    """Return the settings RC of matplotlib, with this machine's fonts and figures of 1 or 2 columns of a paper."""
    return RC | {"font.family": list(families()), "figure.figsize": (WIDTHS_IN[columns], 3.0)}


def width() -> float:
    """Return the current width of figures, inches."""
    import matplotlib

    return float(matplotlib.rcParams["figure.figsize"][0])
