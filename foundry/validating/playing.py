"""Runs scripted policies over many seeds, and compares each result with the value that a formula gives."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

from foundry import calling
from foundry.errors import FoundryError

if TYPE_CHECKING:
    from analysis.validation.facts import ClosedForm, Facts


Z = 4.0
"""Allowed deviation of a mean, in standard errors. A correct value fails by chance about once in 16,000 checks."""
_ROUNDING = 1e-9
COLUMNS = ("world", "closed form", "measure", "n", "found", "known", "holds")
_NOTHING = 1e-12
_HEAD = f"""# Validation

Scripted policies play each world, and foundry compares their results with known ones. This command writes the page,
without any model:

    foundry check --known --write benchmarks/known_results.md

`found` is the mean over n seeds with its standard error. A result holds if it differs from the known number by at most
{Z:g} standard errors plus the rounding of this number.
"""


@dataclass(frozen=True)
class KnownResult:
    """The result of a scripted policy, with the known value.

    Attributes:
        column: the measure.
        result: mean over seeds.
        error: its standard error; 0 if every seed gives the same value.
        tolerance: error by rounding of the known value.
        why: derivation of the known value.
    """

    world: str
    name: str
    command: str
    column: str
    n: int
    result: float
    error: float
    value: float
    tolerance: float
    why: str

    @property
    def holds(self) -> bool:
        """True if the result differs from the known value by at most `Z` standard errors plus the tolerance."""
        return abs(self.result - self.value) <= self.tolerance + Z * self.error + _ROUNDING * max(abs(self.value), 1.0)


def hold(facts: Facts, folder: Path, mine: Sequence[Path] = ()) -> Iterator[KnownResult]:
    """Run all scripted policies of a world that have known values, and yield each result."""
    alike: dict[tuple[Any, ...], list[ClosedForm]] = {}
    for closed_form in facts.closed_forms:
        alike.setdefault((closed_form.policy, closed_form.overrides, closed_form.seeds), []).append(closed_form)
    for place, forms in enumerate(alike.values()):
        yield from _played(facts.world, forms, folder / f"{facts.world}-{place}", mine)


def _played(world: str, forms: Sequence[ClosedForm], folder: Path, mine: Sequence[Path]) -> Iterator[KnownResult]:
    """Run a policy once, and yield one result for each known value (measure) of it."""
    from analysis.validation.run_values import values_of

    first = forms[0]
    asked = (f"world={world}", f"model={first.policy}", f"seed=0-{first.seeds - 1}", *first.overrides)
    where = (f"output.dir={folder}", "cache.path=''", "analyze=false")
    ran = calling.sweep(*asked, *where, config_dir=mine[0] if mine else None)
    if ran.failed:
        raise FoundryError(f"The known value '{first.name}' of world '{world}' cannot be checked: {ran.failed[0]}")
    command = f"foundry -m {shlex.join(asked)}" + (f" --config-dir {mine[0]}" if mine else "")
    values = values_of(ran.path, [form.column for form in forms])
    for form in forms:
        result, error = _mean(values[form.column])
        yield KnownResult(
            world=world, name=form.name, command=command, column=form.column, n=first.seeds, result=result, error=error,
            value=form.value, tolerance=form.tolerance, why=form.why,
        )  # fmt: skip


def _mean(values: Sequence[float]) -> tuple[float, float]:
    mean = math.fsum(values) / len(values)
    spread = math.sqrt(math.fsum((value - mean) ** 2 for value in values) / max(len(values) - 1, 1))
    return mean, spread / math.sqrt(len(values))


def row(result: KnownResult) -> tuple[str, ...]:
    """Return a result as a row of a table; the columns are COLUMNS."""
    known = f"{result.value:g}" + (f" ± {result.tolerance:g}" if result.tolerance else "")
    return (
        result.world,
        result.name,
        result.column,
        str(result.n),
        result_text(result),
        known,
        "yes" if result.holds else "NO",
    )


def result_text(known: KnownResult) -> str:
    """Return the result, with its standard error if it is not 0."""
    result = known.result if abs(known.result) > _NOTHING else 0.0
    return f"{result:.6g}" + (f" ± {known.error:.2g}" if known.error else "")


def page(held: Sequence[KnownResult]) -> str:
    """Return the page in Markdown, one section per world."""
    sections = [_section(world, list(group)) for world, group in groupby(held, key=lambda result: result.world)]
    return "\n".join([_HEAD, *sections])


def _section(world: str, held: Sequence[KnownResult]) -> str:
    head = f"| {' | '.join(COLUMNS[1:])} |\n|{'---|' * (len(COLUMNS) - 1)}"
    rows = "\n".join(f"| {' | '.join(row(result)[1:])} |" for result in held)
    notes = "\n".join(f"- *{result.name}*: {result.why.rstrip('.')}. `{result.command}`" for result in held)
    return f"## {world}\n\n{head}\n{rows}\n\n{notes}\n"
