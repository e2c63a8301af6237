"""Writes the largest gaps between models as a short table for a terminal, with one row per measure."""

import math
from collections.abc import Iterable, Mapping, Sequence

from analysis.findings.ranking import Finding, upright
from analysis.paper.sentence import Sides
from analysis.prose import text_width
from analysis.tables.texts import rounded

LONGEST_NAME = 16
"""Maximum number of characters of a name in the table; `…` replaces the middle of a longer name."""
_SPACE = "  "


def gap_lines(
    findings: Sequence[Finding], names: Mapping[str, str], contexts: Mapping[str, str], sides: Sides, width: int
) -> list[str]:
    """Return the lines of the table: a column per level, or the lowest and highest level if there is no room."""
    levels = [level for level in names if any(level in gap.means for gap in findings)]
    labels = [_label(gap, contexts, sides, 7 * width // 20) for gap in findings]
    sizes = [upright(gap.rows[0]) for gap in findings]
    pairs = _padded([f"{names[gap.level]} - {names[gap.other_levels[0]]}" for gap in findings])
    means = [rounded([gap.means.get(level, math.nan) for level in levels]) for gap in findings]
    cells = sizes if len(levels) == 2 else [f"{pair}{_SPACE}{size}" for pair, size in zip(pairs, sizes, strict=True)]
    lines = aligned(
        [
            ["", *(names[level] for level in levels), "largest gap [95 %]"],
            *([label, *own, cell] for label, own, cell in zip(labels, means, cells, strict=True)),
        ]
    )
    if max(map(text_width, lines)) <= width:
        return lines
    ends = [_ends(gap, names) for gap in findings]
    head = ["", "lowest", "highest"]
    lines = aligned(
        [[*head, "gap [95 %]"], *([label, *end, size] for label, end, size in zip(labels, ends, sizes, strict=True))]
    )
    if max(map(text_width, lines)) <= width:
        return lines
    return aligned([head, *([label, *end] for label, end in zip(labels, ends, strict=True))])


def _ends(gap: Finding, names: Mapping[str, str]) -> list[str]:
    levels = (gap.other_levels[0], gap.level)
    means = rounded([gap.means[level] for level in levels])
    return [f"{names[level]} {mean}" for level, mean in zip(levels, means, strict=True)]


def _label(gap: Finding, contexts: Mapping[str, str], sides: Sides, most: int) -> str:
    words = sides.describe(gap.rows[0]).label.partition(" (")[0]
    candidates = (words, gap.measure, words.partition(",")[0])
    label = next((text for text in candidates if text_width(text) <= most), gap.measure)
    context = contexts[str(gap.rows[0]["context"])]
    return f"{label}, {context}" if context else label


def short_names(levels: Iterable[str]) -> dict[str, str]:
    """Shorten the names of levels: drop a folder that all names share, and replace the middle of long names by `…`."""
    known = list(dict.fromkeys(levels))
    folders = {level.rpartition("/")[0] for level in known}
    plain = {level: level.rpartition("/")[2] if len(folders) == 1 else level for level in known}
    return shortened(plain, LONGEST_NAME)


def shortened(names: Mapping[str, str], most: int) -> dict[str, str]:
    """Replace the middle of names longer than `most` by `…`; keep more of it if two names would become equal."""
    half = most // 2
    short = {key: name if len(name) <= most else f"{name[:half]}…{name[1 - half :]}" for key, name in names.items()}
    return short if len(set(short.values())) == len(set(names.values())) else shortened(names, most + 4)


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return one line of text per row, in which the cells of each column have the same width."""
    columns = [_padded(column) for column in zip(*rows, strict=True)]
    return [_SPACE.join(cells).rstrip() for cells in zip(*columns, strict=True)]


def _padded(texts: Sequence[str]) -> list[str]:
    widest = max(map(text_width, texts))
    return [text + " " * (widest - text_width(text)) for text in texts]
