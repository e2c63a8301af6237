"""Colours, markers and dashes of models, baselines and decisions in plots, in the report and on the pages.

A model's colour, marker and dashes depend on its index among the models of its sweep, in the order of first runs. All
colours of models and baselines have a contrast of at least 3:1 on their background (WCAG 2.2, 1.4.11). The markers of
the first twelve models differ, so that they can be told apart without colours.
"""

import math
from colorsys import hls_to_rgb
from dataclasses import dataclass

Polygon = tuple[tuple[float, float], ...]
"""Corners of a closed polygon in the unit circle, with y upwards; the last corner equals the first."""

COLOURS = (
    "#0079CE",
    "#780000",
    "#D47866",
    "#005C47",
    "#3A1CC5",
    "#75637A",
    "#785700",
    "#019903",
    "#42334F",
    "#8091B3",
    "#A70F44",
    "#564E7E",
)
"""Colours of models on a light background.

Any two of these twelve colours differ by at least 9.9 in CIEDE2000, also for readers who confuse red and green or blue
and yellow (Machado et al. 2009). The first eight colours differ by at least 5 in lightness (CIE L*), so a grey print
distinguishes them.
"""

DARK_COLOURS = (
    "#4B8DB2",
    "#F09D99",
    "#CC4F00",
    "#06FFDA",
    "#C5BBF8",
    "#FC39EC",
    "#FACC74",
    "#7BB400",
    "#8A7055",
    "#A0935E",
    "#63C3BE",
    "#C1919E",
)
"""Colours of the same models on a dark background. These colours differ as much as `COLOURS`, with similar hues."""

BASELINE = "#808080"
"""The colour of all baselines, whose marker is a disc. All have one colour, because nobody compares baselines."""

DASHES = ((), (3.5, 1.5), (1.0, 1.5), (4.5, 1.5, 1.0, 1.5), (6.0, 1.5, 1.0, 1.5, 1.0, 1.5))
"""Alternating lengths of strokes and gaps, in line widths; empty for a solid line."""

LABELS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#F0E442", "#D55E00")
"""Colours of the first labels of decisions (Okabe and Ito); further labels get other hues."""

TURN = 137.5
"""Degrees on the colour circle between the hues of successive further labels. The golden angle repeats no hue."""


def _star(corners: int, turn: float = 0.0, inner: float = 1.0) -> Polygon:
    """Return a polygon whose corners have the distances 1 and `inner` in turn; `turn` rotates it by degrees."""
    angles = [math.radians(turn + 360 * corner / corners) for corner in range(corners + 1)]
    radii = [1.0 if corner % 2 == 0 else inner for corner in range(corners + 1)]
    return tuple(
        (round(radius * math.sin(angle), 3), round(radius * math.cos(angle), 3))
        for radius, angle in zip(radii, angles, strict=True)
    )


_PLUS: Polygon = (
    (-0.33, 1), (0.33, 1), (0.33, 0.33), (1, 0.33), (1, -0.33), (0.33, -0.33), (0.33, -1),
    (-0.33, -1), (-0.33, -0.33), (-1, -0.33), (-1, 0.33), (-0.33, 0.33), (-0.33, 1),
)  # fmt: skip
_CROSS: Polygon = tuple((round((x - y) * 0.75, 3), round((x + y) * 0.75, 3)) for x, y in _PLUS)

MARKERS = (
    _star(4),
    _star(4, 45),
    _star(3),
    _star(3, 180),
    _PLUS,
    _CROSS,
    _star(3, 270),
    _star(3, 90),
    _star(5),
    _star(6),
    _star(10, inner=0.45),
    _star(4, inner=0.55),
)
"""The markers of models: diamond, square, triangles, plus, cross, pentagon, hexagon, star and thin diamond."""

LOOKS = len(COLOURS) * len(MARKERS)
"""Number of pairs of a colour and a marker. From this index on, models repeat these pairs, with other dashes."""


@dataclass(frozen=True)
class Look:
    """The look of a group of runs.

    Attributes:
        colour: colour on a light background, such as in figures, as `#rrggbb`.
        paint: CSS colour for pages, which may be light or dark.
        marker: polygon of the marker; None for a disc.
        dashes: one of `DASHES`.
    """

    colour: str
    paint: str
    marker: Polygon | None
    dashes: tuple[float, ...]


def look(index: int, *, baseline: bool = False) -> Look:
    """Return the look of a model. If a model has several groups of runs, group k gets `look(index + k * LOOKS)`.

    Args:
        index: index among the models of a sweep, or among its baselines.
        baseline: whether it is a baseline.
    """
    place, turn = index % LOOKS, index // LOOKS
    dashes = DASHES[(place + turn) % len(DASHES)]
    if baseline:
        return Look(BASELINE, BASELINE, None, dashes)
    marker = MARKERS[(place + place // len(COLOURS)) % len(MARKERS)]
    light, dark = COLOURS[place % len(COLOURS)], DARK_COLOURS[place % len(COLOURS)]
    return Look(light, f"light-dark({light}, {dark})", marker, dashes)


def label_colour(place: int) -> str:
    """Return the colour of a label, given its index among all labels of its kind of decision."""
    if place < len(LABELS):
        return LABELS[place]
    rgb = hls_to_rgb(place * TURN % 360 / 360, 0.55, 0.65)
    return "#" + "".join(f"{int(255 * part + 0.5):02x}" for part in rgb)
