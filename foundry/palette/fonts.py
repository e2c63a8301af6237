"""Finds fonts on this machine for letters that the usual font lacks."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Set
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.font_manager import FontManager

USUAL_FONT = "DejaVu Sans"
"""The font of plots and pictures, which matplotlib installs."""

FALLBACK_FONTS = (
    "Noto Sans CJK JP",
    "Noto Sans JP",
    "Hiragino Sans",
    "Yu Gothic",
    "Meiryo",
    "IPAexGothic",
    "Noto Serif CJK JP",
)
"""Fonts for letters that the usual font lacks, mainly Japanese; those that are installed are used."""


@lru_cache(maxsize=1)
def families() -> tuple[str, ...]:
    """Return the usual font and the fallback fonts of this machine, in order of preference."""
    from matplotlib.font_manager import fontManager

    return (USUAL_FONT, *fallback_fonts(fontManager))


def fallback_fonts(manager: FontManager) -> tuple[str, ...]:
    """Return the installed fallback fonts.

    matplotlib caches its list of fonts. If the list contains no fallback font, add fonts that were installed later to
    this manager, but not to the cached list.
    """
    from matplotlib.font_manager import findSystemFonts

    if not _known_fallbacks(manager):
        known = {font.fname for font in manager.ttflist}
        for path in sorted(set(findSystemFonts()) - known):
            with contextlib.suppress(OSError, RuntimeError, NotImplementedError):  # no font that it can use
                manager.addfont(path)
    return _known_fallbacks(manager)


def _known_fallbacks(manager: FontManager) -> tuple[str, ...]:
    names = {font.name for font in manager.ttflist}
    return tuple(name for name in FALLBACK_FONTS if name in names)


@lru_cache(maxsize=1)
def letters_by_file() -> Mapping[str, Set[str]]:
    """Return the letters that each font of `families()` can draw, by the path of the font's file."""
    from matplotlib.font_manager import findfont
    from matplotlib.ft2font import FT2Font

    files = (findfont(family, fallback_to_default=False) for family in families())
    return {file: frozenset(map(chr, FT2Font(file).get_charmap())) for file in files}


def lacking(text: str, letters: Set[str]) -> set[str]:
    """Return the visible letters of a text that are not in a set of letters."""
    return {letter for letter in text if letter.isprintable() and not letter.isspace()} - letters
