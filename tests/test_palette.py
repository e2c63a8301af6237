"""How models look, wherever they are drawn."""

from __future__ import annotations

import itertools
import math
import re

import numpy as np
import pytest

from analysis.arrays import FloatArray
from foundry import palette
from foundry.viewer.files import STATIC

REPORT = STATIC.parents[2] / "analysis" / "report" / "templates" / "report.css"

XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
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


def linear(colour: str) -> FloatArray:
    parts = np.array([int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)])
    return np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)


def lab(rgb: FloatArray) -> FloatArray:
    """Return CIELAB of linear sRGB under D65 (IEC 61966-2-1, CIE 15)."""
    xyz = XYZ @ np.clip(rgb, 0, 1) / np.array([0.95047, 1, 1.08883])
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def distance(first: FloatArray, second: FloatArray) -> float:
    """Return CIEDE2000 (CIE 142) between two colours in CIELAB."""
    chroma = (math.hypot(*first[1:]) + math.hypot(*second[1:])) / 2
    stretch = 1.5 - 0.5 * math.sqrt(chroma**7 / (chroma**7 + 25**7))
    (c1, h1), (c2, h2) = (
        (math.hypot(stretch * a, b), math.degrees(math.atan2(b, stretch * a)) % 360) for _, a, b in (first, second)
    )
    turn = (h2 - h1 + 180) % 360 - 180
    hue = (h1 + h2) / 2 + (180 if abs(h1 - h2) > 180 else 0)
    lightness, mean = (first[0] + second[0]) / 2 - 50, (c1 + c2) / 2
    waves = ((0.17, 1, -30, -1), (0.24, 2, 0, 1), (0.32, 3, 6, 1), (0.2, 4, -63, -1))
    weight = 1 + sum(sign * size * math.cos(math.radians(times * hue + by)) for size, times, by, sign in waves)
    by_lightness = (second[0] - first[0]) / (1 + 0.015 * lightness**2 / math.sqrt(20 + lightness**2))
    by_chroma = (c2 - c1) / (1 + 0.045 * mean)
    by_hue = 2 * math.sqrt(c1 * c2) * math.sin(math.radians(turn / 2)) / (1 + 0.015 * mean * weight)
    rotation = -2 * math.sqrt(mean**7 / (mean**7 + 25**7))
    rotation *= math.sin(math.radians(60 * math.exp(-(((hue - 275) / 25) ** 2))))
    return math.sqrt(by_lightness**2 + by_chroma**2 + by_hue**2 + rotation * by_chroma * by_hue)


def test_the_distance_of_colours_is_that_of_the_published_examples():
    """Sharma, Wu and Dalal 2005, table 1: pairs 1, 7 and 25."""
    assert distance(np.array([50, 2.6772, -79.7751]), np.array([50, 0, -82.7485])) == pytest.approx(2.0425, abs=1e-4)
    assert distance(np.array([50, 0, 0]), np.array([50, -1, 2])) == pytest.approx(2.3669, abs=1e-4)
    assert distance(np.array([60.2574, -34.0099, 36.2677]), np.array([60.4626, -34.1751, 39.4387])) == pytest.approx(
        1.2644, abs=1e-4
    )


@pytest.mark.parametrize("seen", SEEN)
def test_eight_models_are_told_apart_by_every_reader_of_colours(seen: str):
    colours = [lab(SEEN[seen] @ linear(colour)) for colour in palette.COLOURS[:8]]
    assert min(distance(*pair) for pair in itertools.combinations(colours, 2)) > 8


def test_eight_models_differ_in_lightness():
    lightness = sorted(lab(linear(colour))[0] for colour in palette.COLOURS[:8])
    assert np.diff(lightness).min() > 1.5


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
