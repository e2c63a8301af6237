"""What scripted policies came to, as a page."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

from foundry.validating.playing import Held, Z

COLUMNS = ("world", "closed form", "measure", "n", "found", "known", "holds")
_ROUNDING = 1e-12
_HEAD = f"""# Validation

Every number below is what scripted policies came to, beside what they must come to. It was made by

    foundry check --known --write docs/validation.md

and needs no model. `found` is the mean over n seeds with its standard error; it holds where it is within {Z:g} standard
errors and the rounding of the known number. A study (n = 0) states its own error.
"""


def row(one: Held) -> tuple[str, ...]:
    """Return a closed form for a table; the columns are COLUMNS."""
    known = f"{one.value:g}" + (f" ± {one.tolerance:g}" if one.tolerance else "")
    return (one.world, one.name, one.column or "study", str(one.n), found(one), known, "yes" if one.holds else "NO")


def found(one: Held) -> str:
    """Return what it came to, with its standard error where there is one."""
    result = one.result if abs(one.result) > _ROUNDING else 0.0
    return f"{result:.6g}" + (f" ± {one.error:.2g}" if one.error else "")


def page(held: Sequence[Held]) -> str:
    """Return the page in Markdown, a section a world."""
    sections = [_section(world, list(group)) for world, group in groupby(held, key=lambda one: one.world)]
    return "\n".join([_HEAD, *sections])


def _section(world: str, held: Sequence[Held]) -> str:
    head = f"| {' | '.join(COLUMNS[1:])} |\n|{'---|' * (len(COLUMNS) - 1)}"
    rows = "\n".join(f"| {' | '.join(row(one)[1:])} |" for one in held)
    notes = "\n".join(f"- *{one.name}*: {one.why.rstrip('.')}. `{one.command}`" for one in held)
    return f"## {world}\n\n{head}\n{rows}\n\n{notes}\n"
