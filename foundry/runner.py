"""Schedules the runs of a sweep on worker processes, outlives their deaths, stops in order."""

from __future__ import annotations

import asyncio
import contextlib
import itertools
import logging
import os
import signal
import threading
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import dataclass, replace
from pathlib import Path
from types import FrameType
from typing import Any

import joblib
from joblib.externals.loky import ProcessPoolExecutor
from joblib.externals.loky.process_executor import BrokenProcessPool

from foundry.build import build
from foundry.errors import BackendError, FoundryError
from foundry.lane import Lane, LaneSpec, run_lane, summarise
from foundry.models.base import Model, ModelInfo
from foundry.store import RunFolder, SweepFolder, write_run_summary
from foundry.sweep import model_key

MAX_DEATHS = 2
"""How often a worker may die with only this run open before the run is given up."""
MAX_IDLE_DEATHS = 5
"""How often a worker may die with no run open before the sweep is given up."""
POLL_S = 0.25


class SweepStopped(FoundryError):
    """The sweep was ended early by an error that no further run could escape."""


class SweepInterrupted(Exception):
    """The user stopped the sweep."""


@dataclass(frozen=True)
class SweepJob:
    """What is to be run.

    Attributes:
        folder: the sweep.
        infos: what the server said about each model, by `sweep.model_key`.
        cache_path: the answer cache.
        frame_every: keep a picture of every n-th step; 0 keeps none.
    """

    folder: SweepFolder
    infos: Mapping[str, ModelInfo]
    cache_path: Path
    frame_every: int


class JoblibRunner:
    """Runs a sweep on worker processes of this machine."""

    def __init__(self, workers: int | None = None, open_runs: int = 16) -> None:
        """Set the size.

        Args:
            workers: worker processes; None for one a core. One works in this very process.
            open_runs: runs that one worker plays at once where a server answers the calls.
        """
        self._workers = workers or joblib.cpu_count()
        self._open_runs = open_runs

    def run(self, job: SweepJob) -> None:
        """Run everything that has not ended; returns when all has, or raises.

        Raises:
            SweepStopped: a failure that no further run could escape.
            SweepInterrupted: the user asked to stop.
        """
        job.folder.start_progress()
        for run in job.folder.runs():
            run.forget_failure()
        try:
            with _stop_on_interrupt(job.folder):
                phases = list(_phases(job))
                for number, phase in enumerate(phases):
                    self._run_phase(job, phase, number)
                    if number + 1 < len(phases):
                        _free_server(job.folder, phase[0])
        finally:
            job.folder.end_progress()

    def _run_phase(self, job: SweepJob, runs: Sequence[RunFolder], number: int) -> None:
        spec = LaneSpec(
            name=f"{number}",
            folder=job.folder,
            runs=tuple(run.id for run in runs),
            infos=job.infos,
            cache_path=job.cache_path,
            frame_every=job.frame_every,
            open_runs=self._open_runs if _remote(runs[0]) else 1,
        )
        workers = min(self._workers, len(runs))
        if workers == 1:
            _raise_if_ended(Lane(replace(spec, name=f"{number}-0")).run(), job.folder)
        else:
            Lanes(spec, workers).run()


class Lanes:
    """Worker processes, one pool each, so that one that dies takes no other with it."""

    def __init__(self, spec: LaneSpec, workers: int) -> None:
        self._spec = replace(spec, parent=os.getpid())
        self._workers = workers
        self._numbers = itertools.count()
        self._pools: dict[Future[str | None], ProcessPoolExecutor] = {}
        self._specs: dict[Future[str | None], LaneSpec] = {}
        self._deaths: Counter[str] = Counter()
        self._idle_deaths = 0

    def run(self) -> None:
        """Work until all runs have ended; a worker that died is replaced."""
        fatal: str | None = None
        try:
            for _ in range(self._workers):
                self._start(())
            while self._pools:
                done, _ = wait(self._pools, timeout=POLL_S, return_when=FIRST_COMPLETED)
                for future in done:
                    fatal = self._collect(future) or fatal
                    if fatal:
                        self._spec.folder.stop_file.touch()
        finally:
            for pool in self._pools.values():
                pool.shutdown(wait=False, kill_workers=True)
        _raise_if_ended(fatal, self._spec.folder)

    def _start(self, suspects: tuple[str, ...]) -> None:
        spec = replace(self._spec, name=f"{self._spec.name}-{next(self._numbers)}", suspects=suspects)
        pool = ProcessPoolExecutor(max_workers=1)
        future = pool.submit(run_lane, spec)
        self._pools[future], self._specs[future] = pool, spec

    def _collect(self, future: Future[str | None]) -> str | None:
        """Take the result of a worker that ended, and replace it if it died."""
        pool, spec = self._pools.pop(future), self._specs.pop(future)
        try:
            return future.result()
        except BrokenProcessPool:
            if not self._spec.folder.stop_file.exists():
                self._start(self._suspects(spec))
            return None
        finally:
            pool.shutdown(wait=False, kill_workers=True)

    def _suspects(self, spec: LaneSpec) -> tuple[str, ...]:
        """Return the runs that were open when the worker died, without those it died of alone too often."""
        opened: list[str] = self._spec.folder.progress().get(spec.name, {}).get("open", [])
        if not opened:
            self._idle_deaths += 1
            if self._idle_deaths > MAX_IDLE_DEATHS:
                raise FoundryError(f"Worker processes died {self._idle_deaths} times before they began a run.")
        if len(opened) == 1:
            self._deaths[opened[0]] += 1
            if self._deaths[opened[0]] >= MAX_DEATHS:
                self._give_up(opened[0])
                return ()
        return tuple(opened)

    def _give_up(self, run: str) -> None:
        folder = next(folder for folder in self._spec.folder.runs() if folder.id == run)
        error = FoundryError(
            f"The worker process died {self._deaths[run]} times while it had only this run open: "
            "it was killed, or ran out of memory."
        )
        summary = summarise(folder, self._spec.infos, None, started="", seconds=0.0, error=error)
        write_run_summary(folder, summary)


def _phases(job: SweepJob) -> Iterator[list[RunFolder]]:
    """Yield the runs that have not ended: those of one served model after those of another, the rest at once.

    A server then loads each model once.
    """
    pending = [run for run in job.folder.runs() if not run.ended]
    for _, runs in itertools.groupby(pending, key=lambda run: _remote(run) and model_key(run.config()["model"])):
        yield list(runs)


def _free_server(folder: SweepFolder, run: RunFolder) -> None:
    """Unload the model of a phase that is over, if the phase called it, to make room for the next one."""
    config = run.config()["model"]
    tallies = [report["models"].get(config["name"], {}) for report in folder.progress().values()]
    if not _remote(run) or not any(tally.get("calls", 0) > tally.get("cached", 0) for tally in tallies):
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


def _remote(run: RunFolder) -> bool:
    return "server" in run.config()["model"]


def _raise_if_ended(fatal: str | None, folder: SweepFolder) -> None:
    if fatal is not None:
        raise SweepStopped(fatal)
    if folder.stop_file.exists():
        raise SweepInterrupted


@contextlib.contextmanager
def _stop_on_interrupt(folder: SweepFolder) -> Iterator[None]:
    """Make the first Ctrl-C ask the workers to stop in order, and the second one stop at once."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def handle(number: int, frame: FrameType | None) -> None:
        if folder.stop_file.exists():
            raise KeyboardInterrupt
        folder.stop_file.touch()

    before: Any = signal.signal(signal.SIGINT, handle)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
