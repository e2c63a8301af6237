"""Small drawn textures: plain surfaces, wood, signs and screens; row 0 is at the top."""

from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from scene_building.stage import Colour

WHITE: Colour = (244, 244, 240)
INK: Colour = (38, 42, 48)
Box = tuple[int, int, int, int]


def shade(colour: Colour, factor: float) -> Colour:
    """Return the colour made darker (below 1) or lighter (above 1)."""
    red, green, blue = (max(0, min(255, round(c * factor))) for c in colour)
    return red, green, blue


def canvas(size: tuple[int, int], colour: Colour) -> tuple[Image.Image, ImageDraw.ImageDraw]:
    """Return an empty picture (width, height) and what draws on it."""
    picture = Image.new("RGB", size, colour)
    return picture, ImageDraw.Draw(picture)


@lru_cache(maxsize=64)
def _font(size: int) -> ImageFont.FreeTypeFont:
    file = Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans-Bold.ttf"
    return ImageFont.truetype(file, size, layout_engine=ImageFont.Layout.BASIC)


def write(draw: ImageDraw.ImageDraw, area: Box, text: str, colour: Colour) -> None:
    """Write a text as large as it fits, in the middle of an area (left, top, right, bottom)."""
    width, height = area[2] - area[0], area[3] - area[1]
    size = 8
    while True:
        left, top, right, bottom = draw.textbbox((0, 0), text, font=_font(size + 1))
        if right - left > width or bottom - top > height:
            break
        size += 1
    centre = ((area[0] + area[2]) / 2, (area[1] + area[3]) / 2)
    left, top, right, bottom = draw.textbbox((0, 0), text, font=_font(size))
    corner = (round(centre[0] - (left + right) / 2), round(centre[1] - (top + bottom) / 2))
    draw.text(corner, text, font=_font(size), fill=colour)


def speckled(picture: Image.Image, strength: int) -> Image.Image:
    """Return the picture with a fine grain; few levels keep the file small."""
    width, height = picture.size
    x, y = np.meshgrid(np.arange(width, dtype=np.uint32), np.arange(height, dtype=np.uint32))
    state = x * np.uint32(374761393) + y * np.uint32(668265263)
    state = (state ^ (state >> np.uint32(13))) * np.uint32(1274126177)
    grain = ((state >> np.uint32(16)) % np.uint32(3)).astype(np.int16) - 1
    pixels = np.asarray(picture, dtype=np.int16) + (grain * strength)[:, :, None]
    return Image.fromarray(np.clip(pixels, 0, 255).astype(np.uint8))


def plain(colour: Colour, strength: int = 3) -> Image.Image:
    """A painted surface with a fine grain."""
    return speckled(canvas((64, 64), colour)[0], strength)


def wall(colour: Colour, skirting: Colour) -> Image.Image:
    """A wall over its whole height: a skirting board, a darker base, joints once per width."""
    picture, draw = canvas((128, 256), colour)
    for row in range(256):
        draw.line((0, row, 127, row), fill=shade(colour, 1.04 - 0.16 * row / 256))
    draw.rectangle((0, 244, 127, 255), fill=skirting)
    draw.line((0, 243, 127, 243), fill=shade(skirting, 0.6))
    draw.line((0, 0, 0, 243), fill=shade(colour, 0.8), width=2)
    return speckled(picture, 1)


def grid(colour: Colour, joint: Colour, *, other: Colour | None = None, strength: int = 2) -> Image.Image:
    """Two by two square tiles with joints, in one colour or two."""
    picture, draw = canvas((128, 128), colour)
    for column, row in ((0, 1), (1, 0)):
        draw.rectangle((64 * column, 64 * row, 64 * column + 63, 64 * row + 63), fill=other or shade(colour, 0.97))
    for at in (0, 64):
        draw.rectangle((at, 0, at + 2, 127), fill=joint)
        draw.rectangle((0, at, 127, at + 2), fill=joint)
    return speckled(picture, strength)


def planks(colour: Colour) -> Image.Image:
    """Four floor boards along u."""
    picture, draw = canvas((256, 128), colour)
    for board, factor in enumerate((1.0, 0.92, 1.05, 0.96)):
        top = 32 * board
        draw.rectangle((0, top, 255, top + 31), fill=shade(colour, factor))
        for line in range(5, 32, 7):
            draw.line((0, top + line, 255, top + line), fill=shade(colour, factor * 0.95))
        draw.line((0, top, 255, top), fill=shade(colour, 0.6), width=2)
        end = (97 * board) % 256
        draw.line((end, top, end, top + 31), fill=shade(colour, 0.6), width=2)
    return picture


def wood(colour: Colour) -> Image.Image:
    """A wooden surface with its grain along u."""
    picture, draw = canvas((64, 64), colour)
    for row in range(0, 64, 4):
        draw.line((0, row, 63, row + (row % 3)), fill=shade(colour, 0.9 + 0.02 * (row % 7)))
    return picture


def sign(text: str, *, paper: Colour, ink: Colour, size: tuple[int, int] = (256, 96)) -> Image.Image:
    """A sign with a border and one or more lines of text."""
    picture, draw = canvas(size, paper)
    width, height = size
    draw.rectangle((4, 4, width - 5, height - 5), outline=ink, width=4)
    lines = text.split("\n")
    step = (height - 24) // len(lines)
    for number, line in enumerate(lines):
        top = 12 + number * step
        write(draw, (18, top + 3, width - 18, top + step - 3), line, ink)
    return picture


def screen(kind: int) -> Image.Image:
    """A screen that shows lines of text (0), a chart (1) or windows (2)."""
    picture, draw = canvas((160, 96), (24, 38, 62))
    painters: Sequence[Callable[[ImageDraw.ImageDraw], None]] = (_text_lines, _chart, _windows)
    painters[kind](draw)
    return picture


def _text_lines(draw: ImageDraw.ImageDraw) -> None:
    for row in range(9):
        draw.rectangle((10, 8 + 9 * row, 30 + (53 * row) % 110, 12 + 9 * row), fill=(96, 214, 150))


def _chart(draw: ImageDraw.ImageDraw) -> None:
    heights = (20, 44, 30, 62, 50, 70, 38)
    for column, height in enumerate(heights):
        draw.rectangle((14 + 20 * column, 88 - height, 26 + 20 * column, 88), fill=(236, 170, 60))
    draw.line((8, 88, 152, 88), fill=WHITE, width=2)


def _windows(draw: ImageDraw.ImageDraw) -> None:
    draw.rectangle((10, 10, 92, 70), fill=(226, 230, 236))
    draw.rectangle((10, 10, 92, 20), fill=(60, 120, 200))
    draw.rectangle((70, 36, 150, 88), fill=(246, 246, 240))
    draw.rectangle((70, 36, 150, 46), fill=(200, 80, 70))


def paper_mark(size: tuple[int, int], paper: Colour, ink: Colour) -> Image.Image:
    """A whiteboard or notice with handwriting-like lines, boxes and an arrow."""
    picture, draw = canvas(size, paper)
    width, height = size
    for row in range(3):
        y = height * (2 + 2 * row) // 10
        draw.line((width // 12, y, width // 12 + width * (3 - row % 2) // 10, y), fill=ink, width=4)
    draw.rectangle((width // 2, height // 5, width * 7 // 10, height // 2), outline=(190, 50, 40), width=4)
    draw.rectangle((width * 8 // 10, height // 2, width * 19 // 20, height * 8 // 10), outline=(40, 130, 70), width=4)
    draw.line((width * 7 // 10, height // 3, width * 8 // 10, height * 6 // 10), fill=(40, 70, 170), width=4)
    return picture


def outdoors() -> Image.Image:
    """The view through a window: sky, far hills, a meadow, in a frame with a cross bar."""
    picture, draw = canvas((128, 128), (150, 196, 232))
    for row in range(70):
        draw.line((0, row, 127, row), fill=(120 + row, 178 + row // 2, 236))
    draw.polygon([(0, 82), (30, 60), (64, 76), (100, 54), (127, 74), (127, 128), (0, 128)], fill=(96, 138, 120))
    draw.rectangle((0, 92, 127, 127), fill=(122, 168, 84))
    draw.rectangle((0, 0, 127, 127), outline=WHITE, width=7)
    draw.rectangle((61, 0, 66, 127), fill=WHITE)
    return picture


def books() -> Image.Image:
    """A row of book spines."""
    picture, draw = canvas((128, 64), (52, 44, 40))
    spines = [
        (176, 58, 46),
        (48, 92, 150),
        (222, 186, 92),
        (70, 128, 84),
        (226, 222, 210),
        (120, 70, 130),
        (210, 120, 60),
    ]
    left = 2
    for number in range(14):
        width, height = 6 + (number * 5) % 5, 46 + (number * 11) % 14
        red, green, blue = spines[number % len(spines)]
        draw.rectangle((left, 63 - height, left + width, 63), fill=(red, green, blue))
        draw.line((left, 58 - height // 2, left + width, 58 - height // 2), fill=WHITE)
        left += width + 2
    return picture


def servers() -> Image.Image:
    """The front of a cabinet of servers with their lights."""
    picture, draw = canvas((96, 256), (34, 38, 46))
    for row in range(12):
        top = 6 + 20 * row
        draw.rectangle((6, top, 89, top + 15), fill=(70, 76, 88))
        for lamp in range(6):
            lit = (row * 5 + lamp * 3) % 4
            colour = ((70, 220, 110), (240, 190, 60), (90, 96, 108), (70, 160, 240))[lit]
            draw.rectangle((12 + 9 * lamp, top + 5, 16 + 9 * lamp, top + 9), fill=colour)
    return picture
