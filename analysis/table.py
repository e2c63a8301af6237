"""One row per run: what it is, how it ended, and every measure of every signature."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from analysis import signatures
from analysis.lines import COMPLETE, FAILED
from analysis.load import further_factors, identity, is_measurable, read_records, read_run
from analysis.signatures import FAILURE_RATE
from foundry.store import RunFolder, SweepFolder

if TYPE_CHECKING:
    import pyarrow as pa  # type: ignore[import-untyped]

PARALLEL_FROM = 65
"""Runs from which several processes are faster than one, their start included."""

KEYS = ("run", "world", "model", "prompt", "seed", "status")
"""The first columns of the table."""


@dataclass(frozen=True)
class RunResult:
    """What the analysis takes from one run.

    Attributes:
        sweep: name of its sweep.
        keys: the columns KEYS.
        factors: the further swept settings.
        config: its effective configuration.
        measures: by `<signature>.<measure>`; FAILURE_RATE alone unless it is a complete run of a 2D or 3D world.
        steps: its steps without texts; None in the same cases.
    """

    sweep: str
    keys: dict[str, Any]
    factors: dict[str, Any]
    config: dict[str, Any]
    measures: dict[str, float]
    steps: pa.Table | None

    def without_steps(self) -> RunResult:
        """Return the same without the steps, which are large."""
        return replace(self, steps=None)


@dataclass(frozen=True)
class SignatureTable:
    """The table and what its columns are.

    Attributes:
        frame: one row per run, in the order of the sweeps; `sweep` when there are several, KEYS, the factors,
            then the measures. What is undefined or missing is NaN.
        factors: the columns that are further swept settings.
        measures: the columns that are measures.
        present: the measures that each row has, defined or not; a run of another kind of world has others.
    """

    frame: pd.DataFrame
    factors: tuple[str, ...]
    measures: tuple[str, ...]
    present: tuple[frozenset[str], ...]


def measure_runs(paths: Sequence[Path], names: Sequence[str]) -> Iterator[RunResult]:
    """Yield every run of the sweeps, in their order; `names` are the names of the sweeps."""
    for path, name in zip(paths, names, strict=True):
        count = len(SweepFolder.open(path).runs())
        if count < PARALLEL_FROM:
            yield from _measure_part(path, name, range(count))
        else:
            yield from _measure_in_parallel(path, name, count)


def _measure_in_parallel(path: Path, name: str, count: int) -> Iterator[RunResult]:
    import joblib

    size = 32  # few enough for an even load, many enough to pay for opening the sweep
    parts = [range(start, min(start + size, count)) for start in range(0, count, size)]
    work = joblib.Parallel(n_jobs=-1, return_as="generator")
    for results in work(joblib.delayed(_measure_part)(path, name, part) for part in parts):
        yield from results


def _measure_part(path: Path, name: str, part: range) -> list[RunResult]:
    """Measure the runs of a sweep with these indices."""
    folders = SweepFolder.open(path).runs()
    return [measure_run(folders[index], name) for index in part]


def measure_run(folder: RunFolder, sweep: str) -> RunResult:
    """Measure one run; one that is not complete, or whose world is neither a 2D nor a 3D one, has none.

    Raises:
        InputError: the settings of its world cannot be read.
        RecordError: a recorded file is damaged.
    """
    from analysis.steps_file import steps_table

    keys = identity(folder)
    measures = {FAILURE_RATE: {COMPLETE: 0.0, FAILED: 1.0}.get(keys["status"], math.nan)}
    steps = None
    if keys["status"] == COMPLETE and is_measurable(folder):
        records = read_records(folder, folder.summary())
        measures |= signatures.measure(read_run(folder, records))
        steps = steps_table(folder.id, records)
    return RunResult(
        sweep=sweep,
        keys=keys,
        factors=further_factors(folder),
        config=folder.config(),
        measures=measures,
        steps=steps,
    )


def build_table(results: Sequence[RunResult]) -> SignatureTable:
    """Return the table of these runs."""
    factors = list(dict.fromkeys(key for result in results for key in result.factors))
    measures = _measure_columns(results)
    by_sweep = len({result.sweep for result in results}) > 1
    rows = [
        {
            **({"sweep": result.sweep} if by_sweep else {}),
            **result.keys,
            **{key: factor_value(result, key) for key in factors},
            **{name: result.measures.get(name, math.nan) for name in measures},
        }
        for result in results
    ]
    head = [*(["sweep"] if by_sweep else []), *KEYS]
    frame = pd.DataFrame(rows, columns=[*head, *factors, *measures])
    present = tuple(frozenset(result.measures) for result in results)
    return SignatureTable(frame, tuple(factors), tuple(measures), present)


def _measure_columns(results: Sequence[RunResult]) -> list[str]:
    """Return the measures by signature, within one in the order of their first appearance."""
    found = list(dict.fromkeys(name for result in results for name in result.measures))
    order = {name: index for index, name in enumerate(dict.fromkeys(name.partition(".")[0] for name in found))}
    return sorted(found, key=lambda name: order[name.partition(".")[0]])


def factor_value(result: RunResult, key: str) -> Any:
    """Return a setting of a run that another sweep swept, too; None where the run has no such setting."""
    value: Any = result.factors.get(key)
    if key not in result.factors:
        value = result.config
        for part in (key.partition("@")[2] or key).split("."):
            value = value.get(part) if isinstance(value, dict) else None
    if isinstance(value, dict):
        return value.get("name", value.get("_target_", str(value)))
    return value if isinstance(value, str | int | float | None) else str(value)
