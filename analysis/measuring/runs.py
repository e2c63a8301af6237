"""Measures runs: computes all signatures, and the other data that the analysis needs."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from analysis import signatures
from analysis.any.any_run import AnyRun
from analysis.any.general import general_run
from analysis.any.label_signature import labelled_texts
from analysis.arrays import FloatArray
from analysis.form import form_of
from analysis.labelling import Labelling, labelling_of, rule_labelling
from analysis.lines import COMPLETE, FAILED, last_step
from analysis.load import further_factors, identity, measurable, status
from analysis.measuring.certainty import columns_of, probabilities_of, with_certainty
from analysis.measuring.events import Event, failure, unreadable_replies
from analysis.measuring.memory import Memory, RunMeasurements, key_of
from analysis.measuring.steps_file import steps_table
from analysis.signatures import FAILURE_RATE
from foundry.declared import Actions
from foundry.own_code import own_folders, use_only
from foundry.storing.store import RunFolder, SweepFolder

if TYPE_CHECKING:
    import pyarrow as pa  # type: ignore[import-untyped]


class Values(Mapping[str, float]):
    """The values of a run's measures, by `<signature>.<measure>`; runs with the same measures share the list of names.

    Attributes:
        names: the measures, in order (M).
    """

    __slots__ = ("_positions", "array", "names")

    def __init__(self, values: Mapping[str, float]) -> None:
        self.names, self._positions = _shared(tuple(values))
        self.array: FloatArray = np.fromiter(values.values(), dtype=np.float64, count=len(values))

    def __getitem__(self, name: str) -> float:
        return float(self.array[self._positions[name]])

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)


@lru_cache(maxsize=64)
def _shared(names: tuple[str, ...]) -> tuple[tuple[str, ...], dict[str, int]]:
    return names, {name: index for index, name in enumerate(names)}


PARALLEL_FROM = 65
"""With at least this number of runs, several processes are faster than one, although starting them takes time."""


@dataclass(frozen=True)
class Source:
    """A sweep to measure, or the baselines of a sweep."""

    folder: SweepFolder
    name: str
    baseline: bool = False
    labelling: Labelling = field(default_factory=rule_labelling)


def sources_of(sweeps: Sequence[SweepFolder], names: Sequence[str], labelled_by_model: bool) -> list[Source]:
    """Return the sweeps and their baselines."""
    sources = [labelling_of(sweep, by_model=labelled_by_model) for sweep in sweeps]
    own = [Source(sweep, name, labelling=said) for sweep, name, said in zip(sweeps, names, sources, strict=True)]
    compared = [source for source in own if source.folder.baselines_dir.exists()]
    beside = [
        replace(source, folder=SweepFolder.open(source.folder.baselines_dir), baseline=True) for source in compared
    ]
    return [*own, *beside]


@dataclass(frozen=True)
class Questions:
    """The decisions for which a world asks.

    Attributes:
        run: class of its runs, which identifies the form.
        actions: the possible decisions for each kind of question.
    """

    world: str
    run: type
    actions: tuple[tuple[str, Actions], ...]

    def are_like(self, other: Questions) -> bool:
        """Return whether all measures are comparable: the world or the possible decisions must be the same."""
        return self.world == other.world or self.actions == other.actions


@dataclass(frozen=True)
class RunResult:
    """The analysis data of one run.

    Attributes:
        measures: measures by `<signature>.<measure>`; an incomplete run has only FAILURE_RATE.
        steps: its steps without texts; None if the run is incomplete.
        copies: values of measures on copies with random labels, (COPIES,) each.
    """

    sweep: str
    keys: dict[str, Any]
    form: str
    questions: Questions
    factors: dict[str, Any]
    config: dict[str, Any]
    baseline: bool
    measures: Values
    steps: pa.Table | None
    events: Sequence[Event]
    copies: Mapping[str, FloatArray] = field(default_factory=dict)

    def without_steps(self) -> RunResult:
        """Return the result without steps and events, which are large."""
        return replace(self, steps=None, events=())

    def without_measures(self) -> RunResult:
        """Return the result without measures, to free memory once a table holds the measures."""
        return replace(self, measures=_NONE, copies={})


_NONE = Values({})


def schemas_of(runs: Sequence[RunFolder]) -> list[pa.Schema]:
    """Return the columns of `steps.parquet` for the given runs, with one schema for each set of declared decisions."""
    declared = {json.dumps(msgspec.to_builtins(run.declared), sort_keys=True): run.declared for run in runs}
    return [*(form_of(declaration.form).schema(declaration) for declaration in declared.values()), *columns_of(runs)]


def measure_runs(sources: Sequence[Source], memory: Memory) -> Iterator[RunResult]:
    """Yield the results of every run, in order, if possible from the cache; then remove other runs from the cache."""
    seen: set[str] = set()
    for source in sources:
        folders = source.folder.runs()
        keys = [key_of(folder, source.labelling.version) for folder in folders]
        fresh = [folder for folder, key in zip(folders, keys, strict=True) if key not in memory]
        measured = _measure_fresh(source, fresh)
        for folder, key in zip(folders, keys, strict=True):
            seen.add(key)
            known = key in memory
            run = (memory.recall(key) or _measured(folder, source.labelling)) if known else next(measured)
            if not known and run.steps is not None:
                memory.keep(key, run)
            yield _described(folder, source, run)
    memory.forget_others(seen)


def _measure_fresh(source: Source, fresh: Sequence[RunFolder]) -> Iterator[RunMeasurements]:
    if len(fresh) < PARALLEL_FROM:
        yield from (_measured(folder, source.labelling) for folder in fresh)
        return
    import joblib

    size = 16  # small enough for an even load and little memory, large enough to be worth the transfer
    parts = [source.folder.part(fresh[start : start + size]) for start in range(0, len(fresh), size)]
    work = joblib.Parallel(n_jobs=-1, return_as="generator")
    for results in work(joblib.delayed(_measure_part)(source.labelling, part, own_folders()) for part in parts):
        yield from results


def _measure_part(labelling: Labelling, part: SweepFolder, own: Sequence[Path]) -> list[RunMeasurements]:
    """Measure some runs of a sweep in another process, after telling it the folders of your own parts."""
    use_only(own)
    return [_measured(folder, labelling) for folder in part.runs()]


def measure_run(folder: RunFolder, source: Source) -> RunResult:
    """Measure one run; an incomplete run has no measures.

    Raises:
        InputError: the settings of its world cannot be read, or a user's own code cannot be used.
        RecordError: a recorded file is damaged.
    """
    return _described(folder, source, _measured(folder, source.labelling))


def _measured(folder: RunFolder, labelling: Labelling) -> RunMeasurements:
    summary = folder.summary()
    ended = status(folder, summary)
    measures = {FAILURE_RATE: {COMPLETE: 0.0, FAILED: 1.0}.get(ended, math.nan)}
    whole = measurable(folder, summary)
    if whole is None:
        return RunMeasurements(measures, None, failure(summary, last_step(folder)) if ended == FAILED else [])
    form, run = whole.form, whole.form.labelled(whole.run, labelling)
    general: AnyRun = run if form.run is AnyRun else general_run(folder, whole.records)
    texts = {own.label.name: labelled_texts(folder, own) for own in labelling.own}
    general = replace(general, labels=texts, probabilities=probabilities_of(folder, whole.records))
    measures |= signatures.measure(general if form.run is AnyRun else run, general)
    corrected, copies = signatures.corrected(run, measures, labelling.corrections)
    events = [*unreadable_replies(general), *form.events(run)]
    steps = steps_table(folder.id, whole.records, form.schema(folder.declared))
    return RunMeasurements(measures | corrected, with_certainty(steps, general.probabilities), events, copies)


def _described(folder: RunFolder, source: Source, measured: RunMeasurements) -> RunResult:
    keys = identity(folder)
    return RunResult(
        sweep=source.name,
        keys=keys,
        form=folder.declared.form,
        questions=Questions(
            keys["world"], form_of(folder.declared.form).run, tuple(sorted(folder.declared.actions.items()))
        ),
        factors=further_factors(folder),
        config=folder.config(),
        baseline=source.baseline,
        measures=Values(measured.measures),
        steps=measured.steps,
        events=measured.events,
        copies=measured.copies,
    )
