"""Textures of the laboratory module: rack fronts made of drawers, vents and screens, labels, windows, the emblem."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from PIL import Image, ImageDraw

from scene_building.stage import Colour
from scene_building.textures import INK, WHITE, Box, canvas, shade, speckled, write

FRONT_SIZE = (256, 536)
EMBLEM_BLUE: Colour = (22, 74, 160)

Draw = ImageDraw.ImageDraw
Part = Callable[[Draw, Box, Colour], None]


@dataclass(frozen=True)
class Row:
    """One part of a rack front and its share of the height."""

    share: float
    part: Part


def rack_front(base: Colour, rows: Sequence[Row]) -> Image.Image:
    """The front of a rack, parts from top to bottom, a dark seam around it."""
    picture, draw = canvas(FRONT_SIZE, base)
    width, height = FRONT_SIZE
    top, inner, total = 30, height - 44, sum(row.share for row in rows)
    for row in rows:
        bottom = top + round(inner * row.share / total)
        row.part(draw, (16, top + 3, width - 17, bottom - 3), base)
        top = bottom
    draw.rectangle((0, 0, width - 1, height - 1), outline=shade(base, 0.32), width=5)
    draw.rectangle((5, 5, width - 6, height - 6), outline=shade(base, 0.8), width=3)
    return picture


def drawers(columns: int, rows: int) -> Part:
    """Lockers in columns and rows, each with a handle."""

    def part(draw: Draw, area: Box, base: Colour) -> None:
        for left, top, right, bottom in _cells(area, columns, rows):
            draw.rectangle((left, top, right, bottom), fill=shade(base, 1.06), outline=shade(base, 0.5), width=2)
            middle, low = (left + right) // 2, bottom - max(7, (bottom - top) // 5)
            draw.rectangle((middle - 14, low - 4, middle + 14, low), fill=INK)

    return part


def vents(draw: Draw, area: Box, base: Colour) -> None:
    """Draw slits for air."""
    draw.rectangle(area, fill=shade(base, 0.85))
    for y in range(area[1] + 4, area[3] - 3, 8):
        draw.rectangle((area[0] + 8, y, area[2] - 8, y + 3), fill=shade(base, 0.42))


def display(draw: Draw, area: Box, base: Colour) -> None:
    """Draw a screen with a curve and two rows of keys beside it."""
    left, top, right, bottom = area
    split = left + (right - left) * 2 // 3
    draw.rectangle(area, fill=shade(base, 0.7))
    draw.rectangle((left + 6, top + 6, split, bottom - 6), fill=(18, 44, 66))
    middle = (top + bottom) / 2
    curve = [(x, middle + (bottom - top) * 0.28 * math.sin((x - left) / 14)) for x in range(left + 10, split - 4, 4)]
    draw.line(curve, fill=(120, 236, 160), width=3)
    for number, (a, b, c, d) in enumerate(_cells((split + 8, top + 6, right - 6, bottom - 6), 2, 4)):
        draw.rectangle((a, b, c, d), fill=((210, 70, 50), (230, 190, 70), (70, 160, 90))[number % 3])


def ports(draw: Draw, area: Box, base: Colour) -> None:
    """Draw two rows of round connectors and cables between them."""
    draw.rectangle(area, fill=shade(base, 0.6))
    radius = min((area[2] - area[0]) // 12, (area[3] - area[1]) // 6)
    for left, top, right, bottom in _cells(area, 4, 2):
        x, y = (left + right) // 2, (top + bottom) // 2
        draw.ellipse((x - radius, y - radius, x + radius, y + radius), fill=(196, 200, 204), outline=INK, width=3)
    third = (area[2] - area[0]) // 3
    draw.arc(
        (area[0] + third // 2, area[1] + 10, area[2] - third // 2, area[3] - 6), 0, 180, fill=(222, 110, 40), width=5
    )


def chamber(draw: Draw, area: Box, base: Colour) -> None:
    """Draw a round chamber door with bolts."""
    draw.rectangle(area, fill=shade(base, 0.92), outline=shade(base, 0.5), width=2)
    x, y = (area[0] + area[2]) // 2, (area[1] + area[3]) // 2
    radius = min(area[2] - area[0], area[3] - area[1]) // 2 - 8
    draw.ellipse((x - radius, y - radius, x + radius, y + radius), fill=(150, 156, 160), outline=INK, width=4)
    inner = radius * 6 // 10
    draw.ellipse((x - inner, y - inner, x + inner, y + inner), fill=(46, 60, 84), outline=WHITE, width=3)
    for k in range(8):
        bx, by = x + 0.82 * radius * math.cos(k * math.pi / 4), y + 0.82 * radius * math.sin(k * math.pi / 4)
        draw.ellipse((bx - 5, by - 5, bx + 5, by + 5), fill=INK)


def bags(draw: Draw, area: Box, base: Colour) -> None:
    """Draw white stowage bags held by straps."""
    for left, top, right, bottom in _cells(area, 1, 2):
        draw.rectangle((left, top, right, bottom), fill=(226, 222, 208), outline=shade(base, 0.45), width=3)
        for x in (left + (right - left) // 4, left + (right - left) * 3 // 4):
            draw.rectangle((x - 5, top, x + 5, bottom), fill=(176, 120, 52))
        draw.rectangle((right - 66, bottom - 34, right - 14, bottom - 12), fill=(244, 214, 90), outline=INK)


def panel(draw: Draw, area: Box, base: Colour) -> None:
    """Draw a plain panel with screws and a coloured stripe."""
    draw.rectangle(area, fill=shade(base, 0.96), outline=shade(base, 0.55), width=2)
    left, top, right, bottom = area
    draw.rectangle((left + 12, (top + bottom) // 2 - 5, right - 12, (top + bottom) // 2 + 5), fill=shade(base, 0.72))
    for x, y in ((left + 10, top + 10), (right - 10, top + 10), (left + 10, bottom - 10), (right - 10, bottom - 10)):
        draw.ellipse((x - 4, y - 4, x + 4, y + 4), fill=shade(base, 0.45))


def deck_plate(base: Colour) -> Image.Image:
    """A floor plate: two covers with studs, screws and a dark seam."""
    picture, draw = canvas(FRONT_SIZE, base)
    width, height = FRONT_SIZE
    for left, top, right, bottom in _cells((12, 12, width - 13, height - 13), 1, 2):
        draw.rectangle((left, top, right, bottom), fill=shade(base, 1.1), outline=shade(base, 0.7), width=3)
        for x in range(left + 22, right - 10, 36):
            for y in range(top + 22, bottom - 10, 36):
                draw.ellipse((x - 4, y - 4, x + 4, y + 4), fill=shade(base, 1.32))
    draw.rectangle((0, 0, width - 1, height - 1), outline=shade(base, 0.5), width=5)
    return speckled(picture, 2)


def _cells(area: Box, columns: int, rows: int) -> list[Box]:
    left, top, right, bottom = area
    wide, high = (right - left) / columns, (bottom - top) / rows
    return [
        (
            round(left + c * wide) + 2,
            round(top + r * high) + 2,
            round(left + (c + 1) * wide) - 2,
            round(top + (r + 1) * high) - 2,
        )
        for r in range(rows)
        for c in range(columns)
    ]


def label_sheet(texts: Sequence[str], columns: int, rows: int) -> Image.Image:
    """All rack labels on one sheet, row by row from the top left."""
    picture, draw = canvas((96 * columns, 32 * rows), WHITE)
    for number, text in enumerate(texts):
        left, top = 96 * (number % columns), 32 * (number // columns)
        draw.rectangle((left, top, left + 95, top + 31), outline=INK, width=2)
        write(draw, (left + 6, top + 6, left + 90, top + 26), text, INK)
    return picture


def emblem() -> Image.Image:
    """The emblem to find: the four letters in a plain font, blue on white, over a bar, in a blue frame."""
    picture, draw = canvas((512, 272), WHITE)
    draw.rectangle((0, 0, 511, 271), outline=EMBLEM_BLUE, width=12)
    write(draw, (30, 26, 482, 210), "JAXA", EMBLEM_BLUE)
    draw.rectangle((34, 222, 477, 240), fill=EMBLEM_BLUE)
    return picture


def earth() -> Image.Image:
    """The view from a window: black space, the blue limb of the Earth, clouds."""
    picture, draw = canvas((192, 192), (8, 10, 22))
    for k, colour in enumerate(((60, 120, 190), (110, 176, 226), (34, 92, 168))):
        inset = 7 * k
        draw.ellipse((-90 + inset, 74 + inset, 282 - inset, 446 - inset), fill=colour)
    for x, y, w in ((40, 120, 60), (96, 146, 80), (20, 160, 50), (130, 112, 40), (70, 176, 90)):
        draw.ellipse((x, y, x + w, y + 9), fill=(232, 240, 246))
    return picture


def lid() -> Image.Image:
    """The round inner door of the airlock: spokes, bolts, a wheel."""
    picture, draw = canvas((192, 192), (168, 174, 178))
    for k in range(12):
        angle = k * math.pi / 6
        x, y = 96 + 80 * math.cos(angle), 96 + 80 * math.sin(angle)
        draw.line((96, 96, x, y), fill=(140, 146, 150), width=5)
        draw.ellipse((x - 6, y - 6, x + 6, y + 6), fill=INK)
    draw.ellipse((56, 56, 136, 136), outline=(206, 150, 40), width=10)
    draw.ellipse((84, 84, 108, 108), fill=(206, 150, 40))
    return picture


def end_plate() -> Image.Image:
    """The inner side of an end of the pressure shell: ribs and rivets."""
    picture, draw = canvas((256, 256), (186, 178, 164))
    for at in range(0, 256, 32):
        draw.line((at, 0, at, 255), fill=(150, 144, 132), width=3)
        for y in range(16, 256, 32):
            draw.ellipse((at + 14, y - 2, at + 18, y + 2), fill=(128, 122, 112))
    return picture
