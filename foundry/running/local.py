"""Schedules the runs of a sweep, model after model, on worker processes of this machine; and stops them in order."""

import asyncio
import contextlib
import functools
import itertools
import logging
import secrets
import signal
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from types import FrameType
from typing import Any, TypeAlias

from foundry import own_code
from foundry.errors import BackendError, FoundryError, InputError, ModelChangedError
from foundry.expansion import is_served, loaded_key, models_in, settings_key
from foundry.models.base import Model, ModelInfo
from foundry.running.build import build
from foundry.running.lane import Lane, LaneSpec
from foundry.running.lanes import Lanes
from foundry.running.progress import most_calls
from foundry.storing.store import RunFolder, SweepFolder


class SweepStopped(FoundryError):
    """The sweep was ended early by an error that would end every further run too."""


class SweepInterrupted(Exception):
    """The user stopped the sweep."""


def new_session() -> str:
    """Return a prefix for names of workers that no other command uses."""
    return secrets.token_hex(4)


@dataclass(frozen=True)
class SweepJob:
    """The runs to play.

    Attributes:
        session: prefix of the names of this command's workers, different from other commands on the same folder.
        after_model: function that is called for each served model when its runs have ended, before it is unloaded. Its
            arguments are the model's configuration, the allowed number of calls in flight (0 if no call was made), and
            a function that says whether to stop.
    """

    folder: SweepFolder
    infos: Mapping[str, ModelInfo]
    cache: str
    frame_every: int
    session: str = field(default_factory=new_session)
    after_model: Callable[[Mapping[str, Any], int, Callable[[], bool]], None] | None = None

    def stop(self) -> None:
        """Ask the workers of this command, but not of other commands on the same folder, to stop in order."""
        self.folder.ask_to_stop(self.session)

    def stop_asked(self) -> bool:
        """Return whether the workers must stop."""
        return self.folder.stop_asked(self.session)


PlayPhase: TypeAlias = Callable[[Sequence[RunFolder], int], None]
"""Plays the runs of a numbered phase; returns when all have ended or the sweep stops."""


class Runner(ABC):
    """Runs a sweep, phase after phase; subclasses say where the workers are."""

    def __init__(self, open_runs: int, ahead: bool = True) -> None:
        """Take the settings of `conf/runner/local.yaml`."""
        self._open_runs = _count("runner.open_runs", open_runs)
        if not isinstance(ahead, bool):
            raise InputError(f"runner.ahead={ahead} is neither true nor false.")
        self._ahead = ahead

    def run(self, job: SweepJob) -> None:
        """Run all runs that have not ended; return when all have ended.

        Raises:
            InputError: the workers cannot be reached, or cannot run this sweep.
            SweepStopped: an error would end every further run too.
            SweepInterrupted: the user stopped the sweep.
        """
        with self.at_work(job) as play:
            try:
                job.folder.start_progress(job.session)
                for run in job.folder.runs():
                    run.forget_failure()
                with _stop_on_interrupt(job):
                    _play_phases(job, play)
            finally:
                job.folder.end_progress(job.session)

    @abstractmethod
    def at_work(self, job: SweepJob) -> AbstractContextManager[PlayPhase]:
        """Connect to the workers and check that they can run the sweep, before the sweep is changed."""

    def spec(self, job: SweepJob, runs: Sequence[RunFolder], number: int) -> LaneSpec:
        """Return the input of the workers of a phase."""
        return LaneSpec(
            name=f"{job.session}-{number}",
            session=job.session,
            folder=job.folder,
            runs=tuple(run.id for run in runs),
            infos=job.infos,
            cache=job.cache,
            frame_every=job.frame_every,
            own=own_code.own_folders(),
            open_runs=self._open_runs if _is_served(runs[0]) else 1,
            ahead=self._ahead,
        )


class LocalRunner(Runner):
    """Runs a sweep on worker processes of this machine."""

    def __init__(self, workers: int | None = None, open_runs: int = 16, ahead: bool = True) -> None:
        """Take the settings of `conf/runner/local.yaml`."""
        super().__init__(open_runs, ahead)
        self._workers = worker_count(workers)

    @contextlib.contextmanager
    def at_work(self, job: SweepJob) -> Iterator[PlayPhase]:
        """Start nothing, since every phase starts its own processes."""
        yield functools.partial(self._play, job)

    def _play(self, job: SweepJob, runs: Sequence[RunFolder], number: int) -> None:
        spec = self.spec(job, runs, number)
        workers = workers_for(runs, self._workers)
        alone = workers == 1
        fatal = Lane(replace(spec, name=f"{spec.name}-0")).run() if alone else Lanes(spec, workers).run()
        raise_if_stopped(fatal, job)


def worker_count(workers: object) -> int | None:
    """Return the setting `runner.workers`: a number from 1, or None for the runner's choice."""
    return None if workers is None else _count("runner.workers", workers)


def _count(key: str, value: object) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < 1:
        raise InputError(f"{key}={value} is not a valid number: give a whole number from 1.")
    return value


def workers_for(runs: Sequence[RunFolder], available: int | None) -> int:
    """Return the number of workers of a phase: `available` or the cores, at most the runs and `server.workers`."""
    servers = [one.get("server") or {} for one in models_in(runs[0].config()["model"])]
    limits: list[int | None] = [server.get("workers") for server in servers]
    useful = min([len(runs), *filter(None, limits)])
    if useful == 1:
        return useful
    import joblib  # takes longer to load than Typer does

    return min(useful, available or int(joblib.cpu_count()))


def raise_if_stopped(fatal: str | None, job: SweepJob) -> None:
    """Raise the error that ended the sweep early, if there is one."""
    if fatal is not None:
        raise SweepStopped(fatal + _undone(job.folder))
    if job.stop_asked():
        raise SweepInterrupted


def _undone(folder: SweepFolder) -> str:
    """Return how much was undone because a model changed; empty if no model did."""
    removed = sum(report.get("removed", 0) for report in folder.progress().values())
    summaries = (run.summary() for run in folder.runs())
    failed = sum(one is not None and one.error_type == ModelChangedError.__name__ for one in summaries)
    return f" ({removed} answers removed, {failed} runs failed)" if removed or failed else ""


def _play_phases(job: SweepJob, play: PlayPhase) -> None:
    phases = list(_phases(job))
    loaded = [loaded_key(phase[0].config()["model"]) for phase in phases]
    for number, phase in enumerate(phases):
        play(phase, number)
        _look_again(job, phase[0].config()["model"], number)
        if number + 1 < len(phases) and loaded[number] != loaded[number + 1]:
            _free_server(job.folder, phase[0])
    played = {settings_key(phase[0].config()["model"]) for phase in phases}
    models = {settings_key(one.config["model"]): one.config["model"] for one in job.folder.sweep.conditions}
    for key in models.keys() - played:
        _look_again(job, models[key], len(phases))


def _look_again(job: SweepJob, model: Mapping[str, Any], number: int) -> None:
    """Call `after_model` for a model whose runs have ended."""
    if job.after_model is None or not is_served(model):
        return
    reports = job.folder.progress().items()
    in_flight = [report.get("in_flight", 0) for lane, report in reports if lane.startswith(f"{job.session}-{number}-")]
    job.after_model(model, max(in_flight, default=0), job.stop_asked)
    raise_if_stopped(None, job)


def _phases(job: SweepJob) -> Iterator[list[RunFolder]]:
    """Yield the unfinished runs by phase: one phase per served model, then all other runs.

    So a server loads each model only once. In each phase the longest runs come first: at the end too few runs are left
    to keep all workers busy, and short runs end soon.
    """
    pending = [run for run in job.folder.runs() if not run.ended]
    most = most_calls(pending)
    for _, runs in itertools.groupby(pending, key=lambda run: _is_served(run) and settings_key(run.config()["model"])):
        yield sorted(runs, key=lambda run: -most[run.run.condition])


def _free_server(folder: SweepFolder, run: RunFolder) -> None:
    """Unload the model of a phase that is over, if the phase called the model, to make room for the next model."""
    config = run.config()["model"]
    tallies = [report["models"].get(config["name"], {}) for report in folder.progress().values()]
    if not _is_served(run) or not any(tally.get("calls", 0) > tally.get("cached", 0) for tally in tallies):
        return
    try:
        asyncio.run(_unload(build(config)))
    except BackendError as error:
        logging.getLogger("foundry").warning("%s could not be unloaded: %s", config["name"], error)


async def _unload(model: Model) -> None:
    try:
        await model.unload()
    finally:
        await model.close()


def _is_served(run: RunFolder) -> bool:
    return is_served(run.config()["model"])


@contextlib.contextmanager
def _stop_on_interrupt(job: SweepJob) -> Iterator[None]:
    """Let the first Ctrl-C ask the workers to stop in order, and the second stop at once."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def handle(number: int, frame: FrameType | None) -> None:
        if job.folder.stop_file(job.session).exists():
            raise KeyboardInterrupt
        job.stop()

    before: Any = signal.signal(signal.SIGINT, handle)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
