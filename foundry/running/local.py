"""Plays the runs of a sweep, one model after another, on worker processes of this machine; Ctrl-C stops them."""

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

STOPPING = "stopping: each run finishes its current step; press Ctrl-C again to stop now"


class SweepStopped(FoundryError):
    """An error stopped the sweep, because the same error would end every further run."""


class SweepInterrupted(Exception):
    """The user stopped the sweep, for example with Ctrl-C."""


def new_session() -> str:
    """Return a name for the session of a command that no other command uses."""
    return secrets.token_hex(4)


@dataclass(frozen=True)
class SweepJob:
    """A sweep to run: its folder, its models, and the settings of its workers.

    Attributes:
        infos: facts about each model from its server, by `expansion.settings_key`.
        cache: file or database with the cache of answers.
        frame_every: n, to store a picture of every n-th step; 0 stores none.
        session: prefix of the names of this command's workers; each command has another one.
        after_model: function that is called when all runs of a served model have ended, before the model is unloaded.
            Its arguments are the model's configuration, the allowed number of calls in flight (0 if no call was made),
            and a function that returns whether to stop.
    """

    folder: SweepFolder
    infos: Mapping[str, ModelInfo]
    cache: str
    frame_every: int
    session: str = field(default_factory=new_session)
    after_model: Callable[[Mapping[str, Any], int, Callable[[], bool]], None] | None = None

    def stop(self) -> None:
        """Tell the workers of this command to stop; workers of other commands on the same folder go on."""
        self.folder.ask_to_stop(self.session)

    def stop_asked(self) -> bool:
        """Return whether the workers of this command must stop."""
        return self.folder.stop_asked(self.session)


PlayPhase: TypeAlias = Callable[[Sequence[RunFolder], int], None]
"""A function that plays the runs of a phase, given these runs and the number of the phase.

The function returns when all runs of the phase have ended or the sweep has stopped.
"""


class Runner(ABC):
    """Plays the runs of a sweep in phases; subclasses define where the workers are."""

    def __init__(self, open_runs: int, ahead: bool = True) -> None:
        """Check and store the settings, which `conf/runner/local.yaml` explains."""
        self._open_runs = _count("runner.open_runs", open_runs)
        if not isinstance(ahead, bool):
            raise InputError(f"runner.ahead={ahead} is neither true nor false. Give true or false.")
        self._ahead = ahead

    def run(self, job: SweepJob) -> None:
        """Play all runs that are not complete, and return when they have ended.

        Raises:
            InputError: the workers cannot be reached, or cannot run this sweep.
            SweepStopped: an error stopped the sweep, because it would end every further run too.
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
        """Connect to the workers and check that they can run the sweep, without a change to the sweep."""

    def spec(self, job: SweepJob, runs: Sequence[RunFolder], number: int) -> LaneSpec:
        """Return the settings of the workers that play one phase."""
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
    """Plays the runs of a sweep on worker processes of this machine."""

    def __init__(self, workers: int | None = None, open_runs: int = 16, ahead: bool = True) -> None:
        """Check and store the settings, which `conf/runner/local.yaml` explains."""
        super().__init__(open_runs, ahead)
        self._workers = worker_count(workers)

    @contextlib.contextmanager
    def at_work(self, job: SweepJob) -> Iterator[PlayPhase]:
        """Yield the function that plays a phase; each phase starts processes of its own on this machine."""
        yield functools.partial(self._play, job)

    def _play(self, job: SweepJob, runs: Sequence[RunFolder], number: int) -> None:
        spec = self.spec(job, runs, number)
        workers = workers_for(runs, self._workers)
        alone = workers == 1
        fatal = Lane(replace(spec, name=f"{spec.name}-0")).run() if alone else Lanes(spec, workers).run()
        raise_if_stopped(fatal, job)


def worker_count(workers: object) -> int | None:
    """Check and return the setting `runner.workers`: a whole number from 1, or None to let the runner choose."""
    return None if workers is None else _count("runner.workers", workers)


def _count(key: str, value: object) -> int:
    if not isinstance(value, int) or isinstance(value, bool) or value < 1:
        raise InputError(f"{key} must be a whole number from 1; got {value}.")
    return value


def workers_for(runs: Sequence[RunFolder], available: int | None) -> int:
    """Return the number of workers of a phase, given its runs and the setting `runner.workers`.

    Without the setting, it is the number of cores. It is at most the number of runs and each server's `workers`.
    """
    servers = [model.get("server") or {} for model in models_in(runs[0].config()["model"])]
    limits: list[int | None] = [server.get("workers") for server in servers]
    useful = min([len(runs), *filter(None, limits)])
    if useful == 1:
        return useful
    import joblib  # takes longer to load than Typer does

    return min(useful, available or int(joblib.cpu_count()))


def raise_if_stopped(fatal: str | None, job: SweepJob) -> None:
    """Raise SweepStopped if the error `fatal` ended the sweep, or SweepInterrupted if the user stopped it."""
    if fatal is not None:
        raise SweepStopped(fatal + _undone(job.folder))
    if job.stop_asked():
        raise SweepInterrupted


def _undone(folder: SweepFolder) -> str:
    """Return how many answers were removed and how many runs failed because a model's weights changed; "" if none."""
    removed = sum(report.get("removed", 0) for report in folder.progress().values())
    summaries = (run.summary() for run in folder.runs())
    failed = sum(summary is not None and summary.error_type == ModelChangedError.__name__ for summary in summaries)
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
    models = {
        settings_key(condition.config["model"]): condition.config["model"] for condition in job.folder.sweep.conditions
    }
    for key in models.keys() - played:
        _look_again(job, models[key], len(phases))


def _look_again(job: SweepJob, model: Mapping[str, Any], number: int) -> None:
    if job.after_model is None or not is_served(model):
        return
    reports = job.folder.progress().items()
    in_flight = [report.get("in_flight", 0) for lane, report in reports if lane.startswith(f"{job.session}-{number}-")]
    job.after_model(model, max(in_flight, default=0), job.stop_asked)
    raise_if_stopped(None, job)


def _phases(job: SweepJob) -> Iterator[list[RunFolder]]:
    """Yield the unfinished runs in phases: one for each served model, and one for all other models.

    So a server loads each model only once. The longest runs of a phase come first, because the last runs cannot keep
    all workers busy, and should be short.
    """
    pending = [run for run in job.folder.runs() if not run.ended]
    most = most_calls(pending)
    for _, runs in itertools.groupby(pending, key=lambda run: _is_served(run) and settings_key(run.config()["model"])):
        yield sorted(runs, key=lambda run: -most[run.run.condition])


def _free_server(folder: SweepFolder, run: RunFolder) -> None:
    """Unload the model of an ended phase, to make room for the next model. Do nothing if the model got no call."""
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
    """Within this context, the first Ctrl-C lets workers finish their current step; the second stops at once."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def handle(number: int, frame: FrameType | None) -> None:
        if job.folder.stop_file(job.session).exists():
            raise KeyboardInterrupt
        logging.getLogger("foundry").warning(STOPPING)
        job.stop()

    before: Any = signal.signal(signal.SIGINT, handle)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
