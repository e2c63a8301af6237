"""The signatures: each module of this package is one, found by being here.

A module defines

- `NAME`: the prefix of its columns;
- `measure(run: GridRun) -> dict[str, float]` for runs of 2D worlds, `measure_camera(run: CameraRun)` for those of
  3D worlds, or both: its measures of one run, without the prefix. Undefined is NaN, never 0; counts that are
  denominators are named `n_...`. A name means the same in both, and which names there are does not depend on what
  happened in the run;
- `MEASURES`: what each measure is called, between which values it can lie, and what chance alone gives, where there
  is such a number; a `*` stands for the name of a place or another configured thing;
- `HEADLINE`: the measures that its plot and the short table show, in their order, `*` included; claims rest on the
  first of them unless others are declared, so none of them may differ between policies that are alike in what it is
  about: `tests/analysis/test_nulls.py` plays such policies;
- optionally `READABLE_TOO = False`, where it makes no sense to leave out the decisions that could not be read.

Every measure is there twice: over all decisions as `<signature>.<measure>`, and as
`<signature>.<measure>_readable` over those alone that could be read, that is whose outcome is `chosen` or
`repaired`. A module counts what the run says that counts: `run.counted` and `run.message_counted`. What is counted by
decision, counts these decisions. What is a mean over states is weighted by the number of counted decisions that led to
each state; what belongs to one agent in a state counts if the agent's own decision that led there does. Of pairs of
decisions both must count.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

from analysis.camera_run import CameraRun
from analysis.described import Measure, share
from analysis.run import GridRun

FAILURE_RATE = "failure.rate"
"""The one column that comes from how runs ended: 1 for a failed run, 0 for a complete one, NaN for others."""

FUNCTIONS: Mapping[type, str] = {GridRun: "measure", CameraRun: "measure_camera"}
"""What a module calls its function for each kind of run."""

READABLE_SUFFIX = "_readable"
"""How the measures over the readable decisions alone end."""


@dataclass(frozen=True)
class Signature:
    """One module of this package.

    Attributes:
        name: the prefix of its columns.
        functions: its measures by kind of run.
        measures: what its measures are.
        headline: those that are shown first.
        readable_too: whether it has measures over the readable decisions alone.
    """

    name: str
    functions: Mapping[type, Callable[[Any], dict[str, float]]]
    measures: Mapping[str, Measure]
    headline: tuple[str, ...]
    readable_too: bool = True

    def measure(self, run: GridRun | CameraRun) -> dict[str, float]:
        """Return the measures of a run over the decisions that count in it; none if there are none for its kind."""
        function = self.functions.get(type(run))
        return function(run) if function else {}

    def columns(self, run: GridRun | CameraRun, readable: GridRun | CameraRun) -> dict[str, float]:
        """Return the columns of a run: its measures, then those of the same run with the readable decisions alone."""
        every = self.measure(run)
        found = {f"{self.name}.{name}": value for name, value in every.items()}
        if self.readable_too:
            alone = every if run.all_readable else self.measure(readable)
            found |= {f"{self.name}.{name}{READABLE_SUFFIX}": value for name, value in alone.items()}
        return found

    def is_readable_only(self, measure: str) -> bool:
        """Return whether a measure, without the signature's name, is over the readable decisions alone."""
        return self.readable_too and measure.endswith(READABLE_SUFFIX)

    def describe(self, measure: str) -> Measure:
        """Return what a measure is; `measure` is without the signature's name."""
        if self.is_readable_only(measure):
            found = self.describe(measure.removesuffix(READABLE_SUFFIX))
            return replace(found, label=f"{found.label}, readable alone")
        if measure in self.measures:
            return self.measures[measure]
        for pattern, described in self.measures.items():
            start, star, end = pattern.partition("*")
            if star and measure.startswith(start) and measure.endswith(end):
                return described.of(measure[len(start) : len(measure) - len(end)])
        return Measure(measure.replace("_", " "), low=0) if measure.startswith("n_") else Measure(measure)

    def headline_columns(self, columns: Iterable[str]) -> list[str]:
        """Return those columns of a table that are this signature's headline over all decisions, in its order."""
        prefix = f"{self.name}."
        present = [
            column
            for column in columns
            if column.startswith(prefix) and not self.is_readable_only(column.removeprefix(prefix))
        ]
        found: list[str] = []
        for pattern in self.headline:
            start, star, _ = f"{prefix}{pattern}".partition("*")
            found += [name for name in present if (name.startswith(start) if star else name == start)]
        return found


@lru_cache(maxsize=1)
def discover() -> tuple[Signature, ...]:
    """Return all signatures by name."""
    modules = [importlib.import_module(f"{__name__}.{found.name}") for found in pkgutil.iter_modules(__path__)]
    found = [
        Signature(
            one.NAME,
            {kind: getattr(one, name) for kind, name in FUNCTIONS.items() if hasattr(one, name)},
            one.MEASURES,
            tuple(one.HEADLINE),
            getattr(one, "READABLE_TOO", True),
        )
        for one in modules
    ]
    return tuple(sorted(found, key=lambda signature: signature.name))


def measure(run: GridRun | CameraRun) -> dict[str, float]:
    """Return every measure of every signature, over all decisions and over the readable ones alone."""
    readable = run.only_readable()
    found: dict[str, float] = {}
    for signature in discover():
        found |= signature.columns(run, readable)
    return found


def is_readable_only(column: str) -> bool:
    """Return whether the column `<signature>.<measure>` is over the readable decisions alone."""
    name, _, measure = column.partition(".")
    return any(one.name == name and one.is_readable_only(measure) for one in discover())


def describe(column: str) -> Measure:
    """Return what the column `<signature>.<measure>` is."""
    if column == FAILURE_RATE:
        return share("Failed runs (share)")
    name, _, measure = column.partition(".")
    by_name = {signature.name: signature for signature in discover()}
    return by_name[name].describe(measure) if name in by_name else Measure(column)
