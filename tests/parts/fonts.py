"""A font made for a test."""

from pathlib import Path

from fontTools.fontBuilder import FontBuilder
from fontTools.pens.ttGlyphPen import TTGlyphPen

EM = 1000


def write_font(path: Path, family: str, letters: str) -> Path:
    """Write a font in which each of these letters is a black square, and every other one nothing at all."""
    names = {letter: f"uni{ord(letter):04X}" for letter in letters}
    nothing, square = TTGlyphPen(None), TTGlyphPen(None)
    square.moveTo((0, 0))
    for corner in ((0, EM), (EM, EM), (EM, 0)):
        square.lineTo(corner)
    square.closePath()
    black = square.glyph()
    builder = FontBuilder(EM, isTTF=True)
    builder.setupGlyphOrder([".notdef", *names.values()])
    builder.setupCharacterMap({ord(letter): name for letter, name in names.items()})
    builder.setupGlyf({".notdef": nothing.glyph(), **dict.fromkeys(names.values(), black)})
    builder.setupHorizontalMetrics(dict.fromkeys((".notdef", *names.values()), (EM, 0)))
    builder.setupHorizontalHeader(ascent=EM, descent=0)
    builder.setupNameTable({"familyName": family, "styleName": "Regular"})
    builder.setupOS2()
    builder.setupPost()
    builder.save(path)
    return path
