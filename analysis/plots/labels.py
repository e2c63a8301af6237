"""Fits names into the width of a paper's column."""

import re
import string
import unicodedata
from collections.abc import Iterable, Mapping, Sequence

from analysis.plots import style

LABEL_WIDTH = 20
"""Maximum number of letters in a line of a label."""

LETTER_IN, TITLE_LETTER_IN, LINE_IN = 0.066, 0.074, 0.13
_MARGINS_IN = 0.2


def wrapped(label: str, width: int = LABEL_WIDTH) -> str:
    """Return a label in lines of at most `width` letters, if possible broken after blanks and `/ : - _ .`.

    Wide East Asian letters count as two.
    """
    lines = [""]
    for piece in re.findall(r"[^\s/:_.-]*[\s/:_.-]*", label):
        for part in _parts(piece, width):
            if letters((lines[-1] + part).rstrip()) > width:
                lines.append("")
            lines[-1] += part
    return "\n".join(line.strip() for line in lines if line.strip())


def letters(text: str) -> int:
    """Return the width of a text in letters."""
    return sum(2 if unicodedata.east_asian_width(one) in "WF" else 1 for one in text)


def _parts(piece: str, width: int) -> Iterable[str]:
    part = ""
    for letter in piece:
        if part and letters(part + letter) > width:
            yield part
            part = ""
        part += letter
    if part:
        yield part


def lines(label: str) -> int:
    """Return the number of lines of a label."""
    return wrapped(label).count("\n") + 1


def title_width(labels: Iterable[str]) -> int:
    """Return the number of letters of a title that fit above a panel, to the right of its labels."""
    longest = max((letters(line) for label in labels for line in wrapped(label).split("\n")), default=0)
    return int((style.width() - _MARGINS_IN - longest * LETTER_IN) / TITLE_LETTER_IN)


def title_height(title: str, width: int) -> float:
    """Return the height of a title's lines beyond the first, inches."""
    return wrapped(title, width).count("\n") * LINE_IN


def keys(names: Sequence[str]) -> Mapping[str, str]:
    """Return letters A, B, ... as short names; if all names are short, return the names."""
    if all(letters(name) <= LABEL_WIDTH // 2 for name in names):
        return {name: name for name in names}
    return {name: _letter(index) for index, name in enumerate(names)}


def _letter(index: int) -> str:
    more, last = divmod(index, len(string.ascii_uppercase))
    return (_letter(more - 1) if more else "") + string.ascii_uppercase[last]
