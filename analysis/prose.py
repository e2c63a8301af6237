"""Small pieces of text for people: lists of names, names of groups, percentages, widths."""

import unicodedata
from collections.abc import Iterable, Sequence


def joined(names: Iterable[str]) -> str:
    """Return names as a list in a sentence, such as `a, b and c`."""
    *first, last = list(names) or ["nothing"]
    return f"{', '.join(first)} and {last}" if first else last


def group_label(group: Sequence[str]) -> str:
    """Return the name of a group, such as `herd / cafe`; equal parts, such as a world and its prompt, appear once."""
    return " / ".join(dict.fromkeys(group))


def percent(share: float) -> str:
    """Return a share as a percentage; a share above zero is never shown as zero."""
    return "<0.1 %" if 0 < share < 0.001 else f"{100 * share:.3g} %"


def text_width(text: str) -> int:
    """Return the width of a line in letters; wide East Asian letters count as two."""
    return sum(2 if unicodedata.east_asian_width(letter) in "WF" else 1 for letter in text)
