"""Writes tables in LaTeX that are no wider than a line.

A table that is too wide gets smaller letters, and columns of equal width with wrapped texts. Columns with one value in
all rows are moved to the caption. If columns of numbers still do not fit, they follow below the table, beside the names
of the rows.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise

from analysis.tables.table import Table

_FITS = 54
"""A row of at most this number of letters fits a line of the LaTeX class `article` in 10 pt."""
_BETWEEN = 2
"""Width of the space between two columns, letters."""
_MOST_COLUMNS = 6
"""Maximum number of columns of wrapped texts side by side."""
_LONGEST_PIECE = 9
"""A text without a good place for a line break may be broken after this number of letters."""
_MOST_ON_A_PAGE = 40
"""Maximum number of rows of a table on one page."""
_BREAKING = "/_=:@+,.-"
"""A line may end after one of these characters if a letter follows."""
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


def to_latex(table: Table, parts: Sequence[Table] = ()) -> str:
    r"""Return a `table`, or a `longtable` for several pages; the first line names the required packages.

    If the table is wider than a line, its `parts`, such as one per world, are written instead.
    """
    is_wide = _letters(table) > _FITS and len(table.columns) > table.labels
    shown = [block for part in parts or [table] for block in _blocks(_without_constants(part))] if is_wide else [table]
    needed = {"array": is_wide, "booktabs": True, "longtable": is_wide or len(table.rows) > _MOST_ON_A_PAGE}
    packages = ",".join(name for name, is_needed in needed.items() if is_needed)
    labels = [table.name, *(f"{table.name}-{number}" for number in range(2, len(shown) + 1))]
    environment = _wide if is_wide else _narrow
    lines = [line for part, label in zip(shown, labels, strict=True) for line in environment(part, label)]
    return "\n".join([rf"% needs \usepackage{{{packages}}}", *lines, ""])


def _letters(table: Table) -> int:
    """Return the number of letters of a row with the longest text of each column; non-ASCII letters count more."""
    widest = (max(len(text.encode()) for text in column) for column in zip(table.columns, *table.rows, strict=True))
    return sum(widest) + _BETWEEN * len(table.columns)


def split_by(table: Table, column: str) -> list[Table]:
    """Split a table into one table for each value of a column, with this value in the caption.

    A table without the column stays whole.
    """
    if column not in table.columns:
        return [table]
    at = table.columns.index(column)
    rest = [index for index in range(len(table.columns)) if index != at]
    parts = {
        value: [row for row in table.rows if row[at] == value] for value in dict.fromkeys(r[at] for r in table.rows)
    }
    return [
        of_columns(replace(table, caption=f"{table.caption} {column.capitalize()}: {value}.", rows=tuple(rows)), rest)
        for value, rows in parts.items()
    ]


def of_columns(table: Table, indices: Sequence[int]) -> Table:
    """Return some columns of a table."""
    return replace(
        table,
        columns=tuple(table.columns[index] for index in indices),
        rows=tuple(tuple(row[index] for index in indices) for row in table.rows),
        labels=sum(index < table.labels for index in indices),
    )


def _without_constants(table: Table) -> Table:
    if len(table.rows) < 2:
        return table
    last = len(table.columns) - 1
    constant = [index for index in range(1, last + 1) if len({row[index] for row in table.rows}) == 1]
    if set(range(table.labels, last + 1)) <= set(constant):
        constant.remove(last)  # a table has numbers
    constants = "; ".join(
        f"{table.columns[index]}: {table.rows[0][index]}" for index in constant if table.rows[0][index]
    )
    shorter = of_columns(table, [index for index in range(last + 1) if index not in constant])
    return replace(shorter, caption=f"{table.caption} In every row: {constants}.") if constants else shorter


def _blocks(table: Table) -> Iterator[Table]:
    """Yield tables with as many columns as fit on a page; each leaves out the rows without values in its columns."""
    room, count = max(1, _MOST_COLUMNS - table.labels), len(table.columns)
    for first in range(table.labels, count, room):
        block = of_columns(table, [*range(table.labels), *range(first, min(first + room, count))])
        yield replace(block, rows=tuple(row for row in block.rows if any(row[table.labels :])))


def _pieces(text: str) -> list[str]:
    """Split a text where a line may break."""
    pieces = [""]
    for letter, following in pairwise(f"{text} "):
        pieces[-1] += letter
        ends = letter in _BREAKING and following.isalpha()
        if letter == " " or ends or len(pieces[-1]) > _LONGEST_PIECE:
            pieces.append("")
    return pieces


def _narrow(table: Table, label: str) -> list[str]:
    head, *rows = (_row(map(_escaped, row)) for row in (table.columns, *table.rows))
    align = "l" * table.labels + "r" * (len(table.columns) - table.labels)
    if len(rows) > _MOST_ON_A_PAGE:
        return _long(table, label, align, head, rows)
    return [
        r"\begin{table}",
        r"\centering",
        _caption(table, label),
        rf"\begin{{tabular}}{{{align}}}",
        *_headed(head),
        *rows,
        r"\bottomrule",
        r"\end{tabular}",
        r"\end{table}",
    ]


def _wide(table: Table, label: str) -> list[str]:
    head, *rows = (_row(map(_wrapped, row)) for row in (table.columns, *table.rows))
    sides = (r"\raggedright" if at < table.labels else r"\raggedleft" for at in range(len(table.columns)))
    width = rf"p{{\dimexpr\linewidth/{len(table.columns)}-2\tabcolsep}}"
    align = "".join(rf">{{{side}\arraybackslash}}{width}" for side in sides)
    return [r"\begingroup\footnotesize", *_long(table, label, align, head, rows), r"\endgroup"]


def _long(table: Table, label: str, align: str, head: str, rows: Sequence[str]) -> list[str]:
    return [
        rf"\begin{{longtable}}{{{align}}}",
        rf"{_caption(table, label)} \\",
        *_headed(head),
        r"\endfirsthead",
        *_headed(head),
        r"\endhead",
        r"\bottomrule",
        r"\endfoot",
        *rows,
        r"\end{longtable}",
    ]


def _caption(table: Table, label: str) -> str:
    return rf"\caption{{{_escaped(table.caption)}}}\label{{tab:{label}}}"


def _headed(head: str) -> list[str]:
    return [r"\toprule", head, r"\midrule"]


def _row(cells: Iterable[str]) -> str:
    return " & ".join(map(_guarded, cells)) + r" \\"


def _escaped(text: str) -> str:
    return "".join(_LATEX.get(letter, letter) for letter in text)


def _wrapped(text: str) -> str:
    return r"\allowbreak{}".join(map(_escaped, _pieces(text))).replace(r" \allowbreak{}", " ")


def _guarded(cell: str) -> str:
    # A bracket at the beginning of a row would be read as the option of the line break before it.
    return f"{{{cell}}}" if cell.startswith("[") else cell
