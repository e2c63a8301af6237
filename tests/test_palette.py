"""How models look, wherever they are drawn."""

from __future__ import annotations

import itertools
import re

from foundry import palette
from foundry.viewer.files import STATIC

REPORT = STATIC.parents[2] / "analysis" / "report" / "templates" / "report.css"


def luminance(colour: str) -> float:
    """Return the relative luminance of a colour (WCAG 2.2)."""
    parts = (int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5))
    red, green, blue = (part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(one: str, other: str) -> float:
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def grounds() -> set[str]:
    """Return what pages and report are drawn on, light and dark."""
    css = (STATIC / "style.css").read_text(encoding="utf-8") + REPORT.read_text(encoding="utf-8")
    return set(re.findall(r"--(?:paper|panel): (#[0-9a-f]{6})", css))


def test_all_colours_of_lines_are_seen_on_every_ground():
    assert len(grounds()) >= 5
    colours = (*palette.COLOURS, palette.BASELINE)
    weak = {pair for pair in itertools.product(colours, grounds()) if contrast(*pair) < 3}
    assert weak == set()


def test_a_dozen_models_differ_in_colour_and_in_marker_and_all_others_in_either():
    dozen = [palette.look(place) for place in range(12)]
    assert len({one.colour for one in dozen}) == len({one.marker for one in dozen}) == 12
    every = [palette.look(place) for place in range(palette.LOOKS)]
    assert len({(one.colour, one.marker) for one in every}) == palette.LOOKS


def test_further_groups_of_a_model_differ_in_their_dashes_alone():
    first, second = palette.look(3), palette.look(3 + palette.LOOKS)
    assert (first.colour, first.marker) == (second.colour, second.marker)
    assert first.dashes != second.dashes


def test_baselines_are_grey_discs():
    assert {(one.colour, one.marker) for one in (palette.look(place, baseline=True) for place in range(4))} == {
        (palette.BASELINE, None)
    }


def test_every_label_has_a_colour_of_its_own():
    colours = [palette.label_colour(place) for place in range(60)]
    assert all(re.fullmatch("#[0-9a-fA-F]{6}", colour) for colour in colours)
    assert len(set(colours)) == 60
