"""How plots look: one column wide, readable in print, told apart with colour-vision deficiencies."""

from __future__ import annotations

import contextlib
from functools import lru_cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.font_manager import FontManager

PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Okabe and Ito, without the yellow that is lost on white."""

MARKERS = ("D", "s", "^", "v")
"""One for each time the colours are used up."""

BASELINE = "#8C8C8C"
"""The colour of all baselines, which are there to be compared with and not with one another."""

FAINT, DARK = "#BBBBBB", "#444444"
FIRE, PLACE = "#D55E00", "#555566"

WIDTH_IN = 3.4
"""One column of a paper, inches."""

DPI = 200

FALLBACK_FONTS = (
    "Noto Sans CJK JP",
    "Noto Sans JP",
    "Hiragino Sans",
    "Yu Gothic",
    "Meiryo",
    "IPAexGothic",
    "Noto Serif CJK JP",
)
"""Fonts for what the first one lacks, Japanese names of places above all; those that are installed are used."""

RC: Any = {
    "font.size": 7.5,
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
}
"""Settings under which plots are made, whatever the user's own are."""


def colour(index: int, *, baseline: bool = False) -> str:
    """Return the colour of the group with this index."""
    return BASELINE if baseline else PALETTE[index % len(PALETTE)]


def marker(index: int, *, baseline: bool = False) -> str:
    """Return the marker of the group with this index; it tells apart those that share a colour."""
    return "o" if baseline else MARKERS[index // len(PALETTE) % len(MARKERS)]


def settings() -> Any:
    """Return RC with the fonts that this machine has."""
    return RC | {"font.family": ["DejaVu Sans", *_own_fallback_fonts()]}


@lru_cache(maxsize=1)
def _own_fallback_fonts() -> tuple[str, ...]:
    from matplotlib.font_manager import fontManager

    return fallback_fonts(fontManager)


def fallback_fonts(manager: FontManager) -> tuple[str, ...]:
    """Return the fallback fonts that are installed.

    matplotlib keeps a list of fonts from its first use on. Where no fallback is in it, fonts that were installed since
    are added to this manager alone; the list that is kept on the disk stays as it is.
    """
    from matplotlib.font_manager import findSystemFonts

    if not _known_fallbacks(manager):
        known = {font.fname for font in manager.ttflist}
        for path in sorted(set(findSystemFonts()) - known):
            with contextlib.suppress(OSError, RuntimeError, NotImplementedError):  # no font that it can draw with
                manager.addfont(path)
    return _known_fallbacks(manager)


def _known_fallbacks(manager: FontManager) -> tuple[str, ...]:
    names = {font.name for font in manager.ttflist}
    return tuple(name for name in FALLBACK_FONTS if name in names)
