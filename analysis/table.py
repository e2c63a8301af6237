"""One row per run: what it is, how it ended, and every measure of every signature."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from analysis import signatures
from analysis.labelling import Labelling, rule_labelling
from analysis.lines import COMPLETE, FAILED
from analysis.load import further_factors, identity, is_measurable, read_records, read_run, status
from analysis.measured import Measured, Memory, key_of
from analysis.measures import Measures
from analysis.run import FloatArray
from analysis.signatures import FAILURE_RATE
from foundry.storing.store import RunFolder, SweepFolder

if TYPE_CHECKING:
    import pyarrow as pa  # type: ignore[import-untyped]

PARALLEL_FROM = 65
"""Runs from which several processes are faster than one, their start included."""

KEYS = ("run", "world", "model", "prompt", "seed", "status")
"""The first columns of the table."""

ANY_PROMPT = "any"
"""The prompt of a baseline among several prompts: scripted policies read none."""


@dataclass(frozen=True)
class Source:
    """Runs to measure: those of a sweep, or of the baselines beside it.

    Attributes:
        path: the folder.
        name: name of the sweep in tables.
        baseline: whether these are its baselines.
        labelling: who says which messages are warnings.
    """

    path: Path
    name: str
    baseline: bool = False
    labelling: Labelling = field(default_factory=rule_labelling)


@dataclass(frozen=True)
class RunResult:
    """What the analysis takes from one run.

    Attributes:
        sweep: name of its sweep.
        keys: the columns KEYS.
        factors: the further swept settings.
        config: its effective configuration.
        baseline: whether it is one of the scripted runs made for comparison.
        measures: by `<signature>.<measure>`; FAILURE_RATE alone unless it is a complete run of a 2D or 3D world.
        steps: its steps without texts; None in the same cases.
    """

    sweep: str
    keys: dict[str, Any]
    factors: dict[str, Any]
    config: dict[str, Any]
    baseline: bool
    measures: Measures
    steps: pa.Table | None

    def without_steps(self) -> RunResult:
        """Return the same without the steps, which are large."""
        return replace(self, steps=None)


@dataclass(frozen=True)
class SignatureTable:
    """The table and what its columns are.

    Attributes:
        frame: one row per run, in the order of the sweeps; `sweep` when there are several, KEYS, `baseline` when
            there are any, the factors, then the measures. What is undefined or missing is NaN.
        factors: the columns that are further swept settings.
        measures: the columns that are measures.
        present: the measures that each row has, defined or not; a run of another kind of world has others.
    """

    frame: pd.DataFrame
    factors: tuple[str, ...]
    measures: tuple[str, ...]
    present: tuple[frozenset[str], ...]


def measure_runs(sources: Sequence[Source], memory: Memory) -> Iterator[RunResult]:
    """Yield every run of the sweeps, in their order; what is in the memory is not measured again.

    Args:
        sources: the sweeps.
        memory: what was measured before; gets what is measured now, and forgets all else.
    """
    seen: set[str] = set()
    for source in sources:
        sweep = SweepFolder.open(source.path)
        folders = sweep.runs()
        keys = [key_of(folder, source.labelling.version) for folder in folders]
        fresh = [folder for folder, key in zip(folders, keys, strict=True) if key not in memory]
        measured = _measure_fresh(source, sweep, fresh)
        for folder, key in zip(folders, keys, strict=True):
            seen.add(key)
            found = (memory.recall(key) or _measured(folder, source)) if key in memory else next(measured)
            if key not in memory and found.steps is not None:
                memory.keep(key, found)
            yield _described(folder, source, found)
    memory.forget_others(seen)


def _measure_fresh(source: Source, sweep: SweepFolder, fresh: Sequence[RunFolder]) -> Iterator[Measured]:
    """Measure these runs of a sweep, by several processes where that is faster."""
    if len(fresh) < PARALLEL_FROM:
        yield from (_measured(folder, source) for folder in fresh)
        return
    import joblib

    size = 16  # few enough for an even load and little memory, many enough to pay for the way to another process
    parts = [sweep.part(fresh[start : start + size]) for start in range(0, len(fresh), size)]
    work = joblib.Parallel(n_jobs=-1, return_as="generator")
    for results in work(joblib.delayed(_measure_part)(source, part) for part in parts):
        yield from results


def _measure_part(source: Source, part: SweepFolder) -> list[Measured]:
    return [_measured(folder, source) for folder in part.runs()]


def measure_run(folder: RunFolder, source: Source) -> RunResult:
    """Measure one run; one that is not complete, or whose world is neither a 2D nor a 3D one, has none.

    Raises:
        InputError: the settings of its world cannot be read.
        RecordError: a recorded file is damaged.
    """
    return _described(folder, source, _measured(folder, source))


def _measured(folder: RunFolder, source: Source) -> Measured:
    from analysis.steps_file import steps_table

    found = folder.summary()
    ended = status(folder, found)
    measures = {FAILURE_RATE: {COMPLETE: 0.0, FAILED: 1.0}.get(ended, math.nan)}
    if ended != COMPLETE or not is_measurable(folder, found):
        return Measured(measures, None)
    records = read_records(folder, found)
    measures |= signatures.measure(source.labelling.label(read_run(folder, records)))
    return Measured(measures, steps_table(folder.id, records))


def _described(folder: RunFolder, source: Source, found: Measured) -> RunResult:
    return RunResult(
        sweep=source.name,
        keys=identity(folder),
        factors=further_factors(folder),
        config=folder.config(),
        baseline=source.baseline,
        measures=Measures(found.measures),
        steps=found.steps,
    )


def build_table(results: Sequence[RunResult]) -> SignatureTable:
    """Return the table of these runs."""
    factors = list(dict.fromkeys(key for result in results for key in result.factors))
    kinds = {names: frozenset(names) for names in dict.fromkeys(result.measures.names for result in results)}
    measures = _measure_columns(kinds)
    by_sweep = len({result.sweep for result in results}) > 1
    by_baseline = any(result.baseline for result in results)
    prompts = {result.keys["prompt"] for result in results if not result.baseline}
    rows = [
        {
            **({"sweep": result.sweep} if by_sweep else {}),
            **result.keys,
            **({"prompt": ANY_PROMPT} if result.baseline and len(prompts) > 1 else {}),
            **({"baseline": result.baseline} if by_baseline else {}),
            **{key: factor_value(result, key) for key in factors},
        }
        for result in results
    ]
    head = [*(["sweep"] if by_sweep else []), *KEYS, *(["baseline"] if by_baseline else [])]
    present = tuple(kinds[result.measures.names] for result in results)
    values = pd.DataFrame(_values(results, kinds, measures), columns=measures)
    frame = pd.concat([pd.DataFrame(rows, columns=[*head, *factors]), values], axis=1)
    return SignatureTable(frame, tuple(factors), tuple(measures), present)


def _values(results: Sequence[RunResult], kinds: Iterable[tuple[str, ...]], measures: Sequence[str]) -> FloatArray:
    """Return the values of all runs (N, M); NaN where a run does not have the measure."""
    column = {name: index for index, name in enumerate(measures)}
    columns = {names: [column[name] for name in names] for names in kinds}
    found = np.full((len(results), len(measures)), np.nan)
    for row, result in zip(found, results, strict=True):
        row[columns[result.measures.names]] = result.measures.array
    return found


def _measure_columns(kinds: Iterable[tuple[str, ...]]) -> list[str]:
    """Return the measures by signature, within one in the order of their first appearance."""
    found = list(dict.fromkeys(name for names in kinds for name in names))
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
