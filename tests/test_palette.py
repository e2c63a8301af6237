"""How models look, wherever they are drawn, and letters that the usual font lacks."""

import copy
import itertools
import re
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from matplotlib.font_manager import FontManager, fontManager

from analysis.arrays import FloatArray
from fonts import write_font
from foundry import palette
from foundry.palette.fonts import fallback_fonts, lacking
from foundry.viewer.files import STATIC

REPORT = STATIC.parents[2] / "analysis" / "report" / "templates" / "report.css"

LMS = np.array(
    [[0.4122214708, 0.5363325363, 0.0514459929], [0.2119034982, 0.6806995451, 0.1073969566],
     [0.0883024619, 0.2817188376, 0.6299787005]]
)  # fmt: skip
OKLAB = np.array(
    [[0.2104542553, 0.7936177850, -0.0040720468], [1.9779984951, -2.4285922050, 0.4505937099],
     [0.0259040371, 0.7827717662, -0.8086757660]]
)  # fmt: skip
"""From linear sRGB to OKLab, by way of the cube roots of LMS (Ottosson 2020)."""
SEEN = {
    "all colours": np.eye(3),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}
"""From linear sRGB to what is seen (Machado, Oliveira and Fernandes 2009, severity 1)."""


def linear(colour: str) -> FloatArray:
    parts = np.array([int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)])
    return np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)


def luminance(colour: str) -> float:
    """Return the relative luminance of a colour (WCAG 2.2)."""
    return float(linear(colour) @ [0.2126, 0.7152, 0.0722])


def oklab(rgb: FloatArray) -> FloatArray:
    return OKLAB @ np.cbrt(LMS @ np.clip(rgb, 0, 1))


def contrast(one: str, other: str) -> float:
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


BACKGROUNDS = ("light", "dark")
MODELS = dict(zip(BACKGROUNDS, (palette.COLOURS, palette.DARK_COLOURS), strict=True))


def backgrounds() -> dict[str, list[str]]:
    """Return the backgrounds of pages and report, for light and dark pages."""
    css = (STATIC / "style.css").read_text(encoding="utf-8") + REPORT.read_text(encoding="utf-8")
    found = re.findall(r"--(?:paper|panel): (#[0-9a-f]{6})", css)
    return {name: [one for one in found if (luminance(one) < 0.5) == (name == "dark")] for name in BACKGROUNDS}


@pytest.mark.parametrize("background", BACKGROUNDS)
def test_all_colours_of_lines_are_seen_on_their_backgrounds(background: str):
    assert len(backgrounds()[background]) >= 3
    pairs = itertools.product((*MODELS[background], palette.BASELINE), backgrounds()[background])
    assert {pair for pair in pairs if contrast(*pair) < 3} == set()


@pytest.mark.parametrize("background", BACKGROUNDS)
@pytest.mark.parametrize("seen", SEEN)
def test_twelve_models_are_told_apart_by_every_reader_of_colours(seen: str, background: str):
    """A difference of 0.02 in OKLab can just be noticed."""
    colours = [oklab(SEEN[seen] @ linear(colour)) for colour in MODELS[background]]
    assert min(np.linalg.norm(one - other) for one, other in itertools.combinations(colours, 2)) > 0.04


def test_a_dozen_models_differ_in_colour_and_in_marker_and_all_others_in_either():
    dozen = [palette.look(place) for place in range(12)]
    assert len({look.colour for look in dozen}) == len({look.marker for look in dozen}) == 12
    every = [palette.look(place) for place in range(palette.LOOKS)]
    assert len({(look.colour, look.marker) for look in every}) == palette.LOOKS


def test_further_groups_of_a_model_differ_in_their_dashes_alone():
    first, second = palette.look(3), palette.look(3 + palette.LOOKS)
    assert (first.colour, first.marker) == (second.colour, second.marker)
    assert first.dashes != second.dashes


def test_every_label_has_a_colour_of_its_own():
    colours = [palette.label_colour(place) for place in range(60)]
    assert all(re.fullmatch("#[0-9a-fA-F]{6}", colour) for colour in colours)
    assert len(set(colours)) == 60


def test_installed_fallbacks_are_named_in_the_order_of_the_list(tmp_path: Path):
    manager = bare_manager()
    for family in ("IPAexGothic", "Noto Sans JP", "Another"):
        manager.addfont(write_font(tmp_path / f"{family}.ttf", family, "火"))
    assert fallback_fonts(manager) == ("Noto Sans JP", "IPAexGothic")


def test_blanks_and_signs_that_are_not_seen_lack_nothing():
    assert lacking("a b\u3000\u200b\n火火", frozenset("ab")) == {"火"}


def bare_manager() -> FontManager:
    manager = copy.copy(fontManager)
    manager.ttflist = [font for font in fontManager.ttflist if font.fname.startswith(matplotlib.get_data_path())]
    return manager
