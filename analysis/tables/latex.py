"""Tables in LaTeX that are no wider than the page of an article.

A table that does not fit is set smaller, its long texts are wrapped, columns that never change go to the caption, and
columns of numbers that have no room go below, behind the names of their rows.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

from analysis.tables.table import Table

PAGE = 345.0
"""Width of a line of `article` in 10 pt, points."""
_GAP = 12.0
"""Between two columns, points."""
_SMALLER = 0.86
"""Width of a letter in `footnotesize` as a share of one in 10 pt."""
_MOST_LABELS, _MOST_NUMBER = 125.0, 90.0
"""Beyond this, the columns of names together and each column of numbers are wrapped, points."""
_LONGEST_PIECE = 9
"""Letters behind which a text may be broken where it has no better place."""
_MOST_ON_A_PAGE = 40
"""Lines of a table that stand on one page."""
_BREAKING = "/_=:@+,.-"
"""Signs behind which a text may be broken before a letter."""
_WIDTHS = {
    **dict.fromkeys("ijl.,:;'|![]", 3.1),
    **dict.fromkeys('frst()- _"`*I', 4.1),
    **dict.fromkeys("mw%=+<>~@&#^", 8.4),
    **dict.fromkeys("ABCDEFGHJKLNOPQRSTUVXYZ", 7.9),
    **dict.fromkeys("MW", 10.4),
}
_USUAL, _FOREIGN = 5.7, 10.0
"""Widths of other letters in 10 pt, rounded up, points: of ASCII and beyond."""
_LATEX = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "$": r"\$",
    "&": r"\&",
    "#": r"\#",
    "%": r"\%",
    "_": r"\_",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    "\N{MINUS SIGN}": "--",
}


@dataclass(frozen=True)
class _Part:
    """A table that stands by itself.

    Attributes:
        table: its texts.
        widths: of its columns, points, where texts are wrapped; empty where none is.
    """

    table: Table
    widths: tuple[float, ...] = ()

    @property
    def is_long(self) -> bool:
        """Whether it needs more than a page."""
        if not self.widths:
            return len(self.table.rows) > _MOST_ON_A_PAGE
        lines = (
            max(math.ceil(_small(text) / width) for text, width in zip(row, self.widths, strict=True))
            for row in self.table.rows
        )
        return sum(max(1, count) for count in lines) > _MOST_ON_A_PAGE


def to_latex(table: Table, parts: Sequence[Table] = ()) -> str:
    r"""Return a `table`, or a `longtable` of more rows than a page holds; the first line says the packages it needs.

    Args:
        table: the whole table.
        parts: the same in parts, such as one a world, which are set where the whole is wider than a page.
    """
    if sum(map(_natural, _columns(table))) + _GAP * len(table.columns) <= PAGE:
        shown = [_Part(table)]
    else:
        shown = [block for part in parts or [table] for block in _blocks(_without_constants(part))]
    needed = {
        "array": any(part.widths for part in shown),
        "booktabs": True,
        "longtable": any(part.is_long for part in shown),
    }
    packages = ",".join(name for name, is_needed in needed.items() if is_needed)
    labels = [table.name, *(f"{table.name}-{number}" for number in range(2, len(shown) + 1))]
    lines = [line for part, label in zip(shown, labels, strict=True) for line in _environment(part, label)]
    return "\n".join([rf"% needs \usepackage{{{packages}}}", *lines, ""])


def split_by(table: Table, column: str) -> list[Table]:
    """Return a table for each value of a column, told in its caption; the table alone where it has no such column."""
    if column not in table.columns:
        return [table]
    at = table.columns.index(column)
    rest = [index for index in range(len(table.columns)) if index != at]
    parts = {
        value: [row for row in table.rows if row[at] == value] for value in dict.fromkeys(r[at] for r in table.rows)
    }
    return [
        _of_columns(replace(table, caption=f"{table.caption} {column.capitalize()}: {value}.", rows=tuple(rows)), rest)
        for value, rows in parts.items()
    ]


def _of_columns(table: Table, indices: Sequence[int]) -> Table:
    return replace(
        table,
        columns=tuple(table.columns[index] for index in indices),
        rows=tuple(tuple(row[index] for index in indices) for row in table.rows),
        labels=sum(index < table.labels for index in indices),
    )


def _without_constants(table: Table) -> Table:
    """Return the table without the columns that say the same in every row; its caption says it."""
    if len(table.rows) < 2:
        return table
    last = len(table.columns) - 1
    constant = [index for index in range(1, last + 1) if len({row[index] for row in table.rows}) == 1]
    if set(range(table.labels, last + 1)) <= set(constant):
        constant.remove(last)  # a table has numbers
    told = "; ".join(f"{table.columns[index]}: {table.rows[0][index]}" for index in constant if table.rows[0][index])
    shorter = _of_columns(table, [index for index in range(last + 1) if index not in constant])
    return replace(shorter, caption=f"{table.caption} In every row: {told}.") if told else shorter


def _blocks(table: Table) -> Iterator[_Part]:
    """Yield blocks of columns that fit, behind the names of their rows; a row with nothing in a block is left out."""
    columns = _columns(table)
    natural = [_natural(texts) * _SMALLER for texts in columns]
    least = [_least(texts, at < table.labels, table.labels) for at, texts in enumerate(columns)]
    names = range(table.labels)
    room = PAGE - sum(least[at] + _GAP for at in names)
    blocks: list[list[int]] = []
    left = 0.0
    for at in range(table.labels, len(columns)):
        if not blocks or least[at] + _GAP > left:
            blocks.append([])
            left = room
        blocks[-1].append(at)
        left -= least[at] + _GAP
    for block in blocks:
        shown = [*names, *block]
        part = _of_columns(table, shown)
        rows = tuple(row for row in part.rows if any(row[table.labels :])) if len(blocks) > 1 else part.rows
        widths = _stretched([least[at] for at in shown], [natural[at] for at in shown])
        yield _Part(replace(part, rows=rows), widths)


def _stretched(least: Sequence[float], natural: Sequence[float]) -> tuple[float, ...]:
    """Return the widths of columns that share the room beyond the least, as far as they need it."""
    wanting = [max(0.0, most - width) for width, most in zip(least, natural, strict=True)]
    room = PAGE - sum(least) - _GAP * len(least)
    share = min(1.0, max(0.0, room) / sum(wanting)) if sum(wanting) else 0.0
    return tuple(width + share * more for width, more in zip(least, wanting, strict=True))


def _least(texts: Sequence[str], is_label: bool, labels: int) -> float:
    """Return the least width of a column in `footnotesize`: of its longest piece, and of whole texts up to a bound."""
    head, *cells = texts
    pieces = max(_small(piece) for text in texts for piece in _pieces(text))
    bound = _MOST_LABELS / labels if is_label else _MOST_NUMBER
    return max(pieces, min(bound, max(map(_small, cells), default=0.0)))


def _columns(table: Table) -> list[list[str]]:
    return [[row[index] for row in (table.columns, *table.rows)] for index in range(len(table.columns))]


def _natural(texts: Sequence[str]) -> float:
    return max(map(_points, texts))


@lru_cache(maxsize=10_000)
def _points(text: str) -> float:
    """Return the width of a text in 10 pt, points; never less than it is."""
    return sum(_WIDTHS.get(letter, _USUAL if letter.isascii() else _FOREIGN) for letter in text)


def _small(text: str) -> float:
    return _points(text) * _SMALLER


def _pieces(text: str) -> list[str]:
    """Return a text in the pieces between which a line may end."""
    pieces = [""]
    for letter, following in pairwise(f"{text} "):
        pieces[-1] += letter
        ends = letter in _BREAKING and following.isalpha()
        if letter == " " or ends or len(pieces[-1]) > _LONGEST_PIECE:
            pieces.append("")
    return pieces


def _environment(part: _Part, label: str) -> list[str]:
    table = part.table
    caption = rf"\caption{{{_escaped(table.caption)}}}\label{{tab:{label}}}"
    cell = _wrapped if part.widths else _escaped
    head, *rows = [" & ".join(map(_guarded, map(cell, row))) + r" \\" for row in (table.columns, *table.rows)]
    headed = [r"\toprule", head, r"\midrule"]
    align = _align(part)
    if part.is_long:
        lines = [
            rf"\begin{{longtable}}{{{align}}}",
            rf"{caption} \\",
            *headed,
            r"\endfirsthead",
            *headed,
            r"\endhead",
            r"\bottomrule",
            r"\endfoot",
            *rows,
            r"\end{longtable}",
        ]
        return [r"\begingroup\footnotesize", *lines, r"\endgroup"] if part.widths else lines
    return [
        r"\begin{table}",
        r"\centering",
        caption,
        *([r"\footnotesize"] if part.widths else []),
        rf"\begin{{tabular}}{{{align}}}",
        *headed,
        *rows,
        r"\bottomrule",
        r"\end{tabular}",
        r"\end{table}",
    ]


def _align(part: _Part) -> str:
    labels = part.table.labels
    if not part.widths:
        return "l" * labels + "r" * (len(part.table.columns) - labels)
    sides = (r"\raggedright" if at < labels else r"\raggedleft" for at in range(len(part.widths)))
    return "".join(
        rf">{{{side}\arraybackslash}}p{{{width:.1f}pt}}" for side, width in zip(sides, part.widths, strict=True)
    )


def _escaped(text: str) -> str:
    return "".join(_LATEX.get(letter, letter) for letter in text)


def _wrapped(text: str) -> str:
    return r"\allowbreak{}".join(map(_escaped, _pieces(text))).replace(r" \allowbreak{}", " ")


def _guarded(cell: str) -> str:
    # A bracket that begins a row would be read as the option of the line break before it.
    return f"{{{cell}}}" if cell.startswith("[") else cell
