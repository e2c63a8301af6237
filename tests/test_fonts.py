"""Letters that the usual font lacks."""

from __future__ import annotations

import copy
from pathlib import Path

import matplotlib
import pytest
from matplotlib.font_manager import FontManager, fontManager

from fonts import write_font
from foundry.palette.fonts import FALLBACK_FONTS, fallback_fonts, lacking


@pytest.mark.exhaustive
def test_fonts_are_found_that_were_installed_since_matplotlib_last_looked():
    manager = bare_manager()
    expected = [name for name in FALLBACK_FONTS if name in {font.name for font in FontManager().ttflist}]
    assert list(fallback_fonts(manager)) == expected


def test_installed_fallbacks_are_named_in_the_order_of_the_list(tmp_path: Path):
    manager = bare_manager()
    for family in ("IPAexGothic", "Noto Sans JP", "Another"):
        manager.addfont(write_font(tmp_path / f"{family}.ttf", family, "火"))
    assert fallback_fonts(manager) == ("Noto Sans JP", "IPAexGothic")


def test_blanks_and_signs_that_are_not_seen_lack_nothing():
    assert lacking("a b\u3000\u200b\n火火", frozenset("ab")) == {"火"}


def bare_manager() -> FontManager:
    """Return a manager that knows matplotlib's own fonts alone."""
    manager = copy.copy(fontManager)
    manager.ttflist = [font for font in fontManager.ttflist if font.fname.startswith(matplotlib.get_data_path())]
    return manager
