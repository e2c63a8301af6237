"""The numbered pictures of the gallery: one distinct shape in one distinct colour each."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from PIL import Image, ImageDraw

from scene_building.stage import Colour
from scene_building.textures import INK, WHITE, canvas, write

SIZE = (288, 224)
MIDDLE = (150.0, 112.0)

Painter = Callable[[ImageDraw.ImageDraw, Colour], None]


@dataclass(frozen=True)
class Motif:
    """The content of a picture: a colour and a shape in words, the colours, and the function that paints the shape."""

    words: str
    colour: Colour
    ground: Colour
    paint: Painter


def _star_points(count: int, outer: float, inner: float, turn: float = -90.0) -> list[tuple[float, float]]:
    points = []
    for k in range(2 * count):
        radius, angle = (outer, inner)[k % 2], math.radians(turn + 180 * k / count)
        points.append((MIDDLE[0] + radius * math.cos(angle), MIDDLE[1] + radius * math.sin(angle)))
    return points


def _disc(radius: float) -> tuple[float, float, float, float]:
    return (MIDDLE[0] - radius, MIDDLE[1] - radius, MIDDLE[0] + radius, MIDDLE[1] + radius)


def polygon(sides: int, turn: float = -90.0) -> Painter:
    """Return what paints a regular polygon."""
    points = [_star_points(sides, 86, 86, turn)[2 * k] for k in range(sides)]
    return lambda draw, colour: draw.polygon(points, fill=colour)


def star(points: int) -> Painter:
    """Return what paints a star."""
    return lambda draw, colour: draw.polygon(_star_points(points, 94, 40), fill=colour)


def circle(draw: ImageDraw.ImageDraw, colour: Colour) -> None:
    """Paint a full circle."""
    draw.ellipse(_disc(82), fill=colour)


def ring(draw: ImageDraw.ImageDraw, colour: Colour) -> None:
    """Paint a ring."""
    draw.ellipse(_disc(86), outline=colour, width=34)


def plus(draw: ImageDraw.ImageDraw, colour: Colour) -> None:
    """Paint an upright cross."""
    x, y = MIDDLE
    draw.rectangle((x - 26, y - 86, x + 26, y + 86), fill=colour)
    draw.rectangle((x - 86, y - 26, x + 86, y + 26), fill=colour)


def heart(draw: ImageDraw.ImageDraw, colour: Colour) -> None:
    """Paint a heart."""
    angles = [math.radians(a) for a in range(0, 360, 6)]
    draw.polygon(
        [
            (
                MIDDLE[0] + 5.4 * 16 * math.sin(a) ** 3,
                MIDDLE[1] - 5.4 * (13 * math.cos(a) - 5 * math.cos(2 * a) - 2 * math.cos(3 * a) - math.cos(4 * a)),
            )
            for a in angles
        ],
        fill=colour,
    )


def crescent(ground: Colour) -> Painter:
    """Return what paints a moon on this ground."""

    def paint(draw: ImageDraw.ImageDraw, colour: Colour) -> None:
        draw.ellipse(_disc(86), fill=colour)
        x, y = MIDDLE
        draw.ellipse((x - 40, y - 92, x + 120, y + 68), fill=ground)

    return paint


def arrow(draw: ImageDraw.ImageDraw, colour: Colour) -> None:
    """Paint an arrow that points to the right."""
    x, y = MIDDLE
    draw.rectangle((x - 90, y - 24, x + 20, y + 24), fill=colour)
    draw.polygon([(x + 10, y - 72), (x + 96, y), (x + 10, y + 72)], fill=colour)


def stripes(draw: ImageDraw.ImageDraw, colour: Colour) -> None:
    """Paint upright stripes."""
    for x in range(84, 250, 44):
        draw.rectangle((x, 24, x + 22, 200), fill=colour)


def waves(draw: ImageDraw.ImageDraw, colour: Colour) -> None:
    """Paint three waves."""
    for row in (60, 112, 164):
        line = [(x, row + 18 * math.sin((x - 70) / 15)) for x in range(64, 250, 3)]
        draw.line(line, fill=colour, width=18, joint="curve")


_NIGHT: Colour = (30, 34, 62)
MOTIFS = (
    Motif("red circle", (206, 36, 40), (246, 236, 214), circle),
    Motif("blue square", (28, 78, 190), (246, 238, 190), polygon(4, -45.0)),
    Motif("green triangle", (34, 140, 66), (240, 224, 232), polygon(3)),
    Motif("yellow star", (250, 208, 40), (40, 60, 120), star(5)),
    Motif("purple cross", (128, 44, 160), (226, 236, 206), plus),
    Motif("orange hexagon", (240, 128, 20), (214, 232, 242), polygon(6)),
    Motif("cyan ring", (20, 190, 206), (66, 36, 40), ring),
    Motif("pink heart", (240, 96, 160), (232, 244, 232), heart),
    Motif("black waves", (24, 24, 28), (150, 214, 216), waves),
    Motif("white moon", (246, 246, 240), _NIGHT, crescent(_NIGHT)),
    Motif("brown arrow", (124, 74, 36), (246, 226, 150), arrow),
    Motif("green stripes", (90, 190, 40), (250, 250, 244), stripes),
)
"""The pictures in the order of their numbers, from 1."""


def picture(number: int) -> Image.Image:
    """Return a picture with its number in the upper left corner."""
    motif = MOTIFS[number - 1]
    image, draw = canvas(SIZE, motif.ground)
    motif.paint(draw, motif.colour)
    draw.rectangle((6, 6, 59, 49), fill=WHITE, outline=INK, width=2)
    write(draw, (11, 11, 55, 45), str(number), INK)
    return image
