"""The signatures: each module of this package is one, found by being here.

A module defines

- `NAME`: the prefix of its columns;
- `measure(run: GridRun) -> dict[str, float]` for runs of 2D worlds, `measure_camera(run: CameraRun)` for those of
  3D worlds, or both: its measures of one run, without the prefix. Undefined is NaN, never 0; counts that are
  denominators are named `n_...`. A name means the same in both;
- `MEASURES`: what each measure is called and between which values it can lie; a `*` stands for the name of a
  place or another configured thing;
- `HEADLINE`: the measures that its plot and the short table show, in their order, `*` included.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from analysis.camera_run import CameraRun
from analysis.described import Measure, share
from analysis.run import GridRun

FAILURE_RATE = "failure.rate"
"""The one column that comes from how runs ended: 1 for a failed run, 0 for a complete one, NaN for others."""

FUNCTIONS: Mapping[type, str] = {GridRun: "measure", CameraRun: "measure_camera"}
"""What a module calls its function for each kind of run."""


@dataclass(frozen=True)
class Signature:
    """One module of this package; `functions` are its measures by kind of run."""

    name: str
    functions: Mapping[type, Callable[[Any], dict[str, float]]]
    measures: Mapping[str, Measure]
    headline: tuple[str, ...]

    def measure(self, run: GridRun | CameraRun) -> dict[str, float]:
        """Return the measures of a run; none if there are none for its kind."""
        function = self.functions.get(type(run))
        return function(run) if function else {}

    def describe(self, measure: str) -> Measure:
        """Return what a measure is; `measure` is without the signature's name."""
        if measure in self.measures:
            return self.measures[measure]
        for pattern, described in self.measures.items():
            start, star, end = pattern.partition("*")
            if star and measure.startswith(start) and measure.endswith(end):
                return described.of(measure[len(start) : len(measure) - len(end)])
        return Measure(measure.replace("_", " "), low=0) if measure.startswith("n_") else Measure(measure)

    def headline_columns(self, columns: Iterable[str]) -> list[str]:
        """Return those columns of a table that are this signature's headline, in its order."""
        present = [column for column in columns if column.startswith(f"{self.name}.")]
        found: list[str] = []
        for pattern in self.headline:
            start, star, _ = f"{self.name}.{pattern}".partition("*")
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
        )
        for one in modules
    ]
    return tuple(sorted(found, key=lambda signature: signature.name))


def measure(run: GridRun | CameraRun) -> dict[str, float]:
    """Return every measure of every signature, by `<signature>.<measure>`."""
    return {
        f"{signature.name}.{name}": value for signature in discover() for name, value in signature.measure(run).items()
    }


def describe(column: str) -> Measure:
    """Return what the column `<signature>.<measure>` is."""
    if column == FAILURE_RATE:
        return share("Failed runs (share)")
    name, _, measure = column.partition(".")
    by_name = {signature.name: signature for signature in discover()}
    return by_name[name].describe(measure) if name in by_name else Measure(column)
