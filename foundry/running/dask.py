"""Runs a sweep on the workers of a Dask cluster that exists already, through joblib."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import joblib

from foundry.errors import InputError
from foundry.expansion import is_served
from foundry.running.dask_cluster import (
    DaskBackend,
    WorkersLost,
    check_cache,
    check_folder,
    connected,
    scheduler_lost,
    survey,
)
from foundry.running.lane import LaneSpec
from foundry.running.lanes import Lanes
from foundry.running.local import PlayPhase, Runner, SweepJob, SweepStopped, raise_if_stopped, worker_count, workers_for
from foundry.running.remote import RemoteSweep
from foundry.running.remote_runs import Chunk, Played, RemoteRuns, play_chunk
from foundry.storing.store import SWEEP_FILE, RunFolder, SweepFolder
from foundry.texts import without_secrets


class DaskRunner(Runner):
    """Runs a sweep on a Dask cluster, its folder on a shared file system or each run sent to a URL."""

    def __init__(
        self,
        address: str,
        workers: int | None = None,
        open_runs: int = 16,
        remote: str | None = None,
        ahead: bool = True,
    ) -> None:
        """Set where the cluster is.

        Args:
            address: of the scheduler.
            workers: how many work at once; None for one a thread of the cluster's workers.
            open_runs: runs that one worker plays at once where a server answers the calls.
            remote: fsspec URL that the runs are sent to; None where all machines share the sweep's folder.
            ahead: whether agents that nothing undecided can touch are asked before the others have answered.

        Raises:
            InputError: the address has no scheme, one is no number of workers or runs, or neither true nor false.
        """
        super().__init__(open_runs, ahead)
        if "://" not in address:
            raise InputError(f"runner.address={address} does not say how it is reached: write tcp://{address}.")
        self._address = address
        self._workers = worker_count(workers)
        self._remote = remote

    @contextlib.contextmanager
    def at_work(self, job: SweepJob) -> Iterator[PlayPhase]:
        """Connect, and check that the workers are fit for the sweep."""
        folder = job.folder
        job = replace(job, folder=SweepFolder(folder.path.absolute(), folder.sweep, folder.settings, folder.models))
        remote = RemoteSweep.open(self._remote) if self._remote else None
        with connected(self._address) as client:
            sites = survey(client, self._address, job.folder.path / SWEEP_FILE)
            if any(is_served(condition.config["model"]) for condition in folder.sweep.conditions):
                check_cache(sites, job.cache)
            if remote is None:
                check_folder(sites, job.folder.path)
                yield functools.partial(self._play, client, job)
            else:
                runs = RemoteRuns(job.folder, remote)
                runs.begin()
                yield functools.partial(self._play_remotely, client, job, runs)

    def _play(self, client: Any, job: SweepJob, runs: Sequence[RunFolder], number: int) -> None:
        """Give every worker the whole list: each takes what no other has, also what a dead one had."""
        spec = self.spec(job, runs, number)

        def attempt() -> str | None:
            given = [replace(spec, name=f"{spec.name}-{lane}", workers=workers) for lane in range(workers)]
            tasks = [joblib.delayed(work)(one) for one in given]
            return _first(_parallel(client, tasks, at_once="all"))

        workers = self._size(client, runs)
        raise_if_stopped(self._outlive(client, attempt, runs), job)

    def _play_remotely(
        self, client: Any, job: SweepJob, remote: RemoteRuns, runs: Sequence[RunFolder], number: int
    ) -> None:
        """Hand out chunks, since no lock holds where there is no shared folder; fetch what has ended."""
        spec = self.spec(job, runs, number)
        workers = self._size(client, runs)

        def attempt() -> str | None:
            fatal = None
            tasks = (joblib.delayed(play)(chunk) for chunk in remote.chunks(spec, workers))
            for played in _parallel(client, tasks, at_once=workers):
                remote.take(played)
                fatal = fatal or played.fatal
                if fatal:
                    job.stop()
            return fatal

        raise_if_stopped(self._outlive(client, attempt, runs), job)

    def _outlive(self, client: Any, attempt: Callable[[], str | None], runs: Sequence[RunFolder]) -> str | None:
        """Try again when Dask gives up a task whose workers died, as long as the sweep gets on meanwhile."""
        while True:
            ended = sum(run.ended for run in runs)
            try:
                return attempt()
            except WorkersLost as error:
                if client.status != "running" or sum(run.ended for run in runs) == ended:
                    raise SweepStopped(
                        f"the cluster at {without_secrets(self._address)} lost its workers: {error}"
                    ) from error

    def _size(self, client: Any, runs: Sequence[RunFolder]) -> int:
        return workers_for(runs, self._workers or max(1, sum(client.ncores().values())))


def work(spec: LaneSpec) -> str | None:
    """Be one of the workers, on a machine of the cluster; returns the cause that must end the sweep, or None."""
    return Lanes(spec, 1, scheduler_lost()).run()


def play(chunk: Chunk) -> Played:
    """Play a chunk of the runs, on a machine of the cluster."""
    return play_chunk(chunk, scheduler_lost())


def _parallel(client: Any, tasks: Iterable[Any], at_once: int | str) -> Iterator[Any]:
    """Yield the results of tasks in the order of their ends."""
    with joblib.parallel_config(backend=DaskBackend(client=client)):
        parallel = joblib.Parallel(n_jobs=-1, batch_size=1, pre_dispatch=at_once, return_as="generator_unordered")
        yield from parallel(tasks)


def _first(causes: Iterable[str | None]) -> str | None:
    return next(filter(None, list(causes)), None)
