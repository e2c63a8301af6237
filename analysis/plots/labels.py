"""Fits names into a column of a paper."""

import re
import string
from collections.abc import Iterable, Mapping, Sequence

from analysis.plots import style
from analysis.prose import text_width

LABEL_WIDTH = 20
"""Maximum number of letters in a line of a label."""

LETTER_IN, TITLE_LETTER_IN, LINE_IN = 0.066, 0.074, 0.13
_MARGINS_IN = 0.2


def wrapped(label: str, width: int = LABEL_WIDTH) -> str:
    """Break a label into lines of at most `width` letters, if possible after blanks and `/ : - _ .`."""
    lines = [""]
    for piece in re.findall(r"[^\s/:_.-]*[\s/:_.-]*", label):
        for part in _parts(piece, width):
            if text_width((lines[-1] + part).rstrip()) > width:
                lines.append("")
            lines[-1] += part
    return "\n".join(line.strip() for line in lines if line.strip())


def _parts(piece: str, width: int) -> Iterable[str]:
    part = ""
    for letter in piece:
        if part and text_width(part + letter) > width:
            yield part
            part = ""
        part += letter
    if part:
        yield part


def lines(label: str) -> int:
    """Return the number of lines of a label."""
    return wrapped(label).count("\n") + 1


def title_width(labels: Iterable[str]) -> int:
    """Return how many letters of a title fit above a panel, to the right of its labels."""
    longest = max((text_width(line) for label in labels for line in wrapped(label).split("\n")), default=0)
    return int((style.width() - _MARGINS_IN - longest * LETTER_IN) / TITLE_LETTER_IN)


def title_height(title: str, width: int) -> float:
    """Return the additional height of a title with several lines, inches."""
    return wrapped(title, width).count("\n") * LINE_IN


def keys(names: Sequence[str]) -> Mapping[str, str]:
    """Return a short name for each name: the letters A, B, ..., or the names if all of them are short."""
    if all(text_width(name) <= LABEL_WIDTH // 2 for name in names):
        return {name: name for name in names}
    return {name: _letter(index) for index, name in enumerate(names)}


def _letter(index: int) -> str:
    more, last = divmod(index, len(string.ascii_uppercase))
    return (_letter(more - 1) if more else "") + string.ascii_uppercase[last]
