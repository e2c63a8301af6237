"""Plays the runs of a sweep on the workers of a Dask cluster, through joblib."""

from __future__ import annotations

import asyncio
import contextlib
import functools
import logging
import socket
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import joblib
from joblib._dask import DaskDistributedBackend

from foundry import provenance
from foundry.errors import FoundryError, InputError
from foundry.expansion import is_served
from foundry.models.answers.answers import is_database
from foundry.running.lane import LaneSpec
from foundry.running.lanes import Lanes
from foundry.running.local import PlayPhase, Runner, SweepJob, SweepStopped, raise_if_stopped, worker_count, workers_for
from foundry.running.remote import Chunk, Played, RemoteRuns, RemoteSweep, play_chunk
from foundry.storing.store import SWEEP_FILE, RunFolder, SweepFolder
from foundry.texts import one_line, without_secrets

CONNECT_S = 5
_CHATTY = ("distributed", "distributed.client", "distributed.core", "distributed.comm")
"""Loggers that print a traceback when a connection is lost; foundry prints a line instead."""
_INSTALL = "pip install 'foundry-worlds[dask]'"


class WorkersLost(FoundryError):
    """A task has no result, because its workers or the scheduler died."""


@dataclass(frozen=True)
class Site:
    """The software, host and files of a worker of the cluster.

    Attributes:
        versions: versions of foundry, Python and all packages that can change a record.
        sees: whether the worker can read the sweep's file.
    """

    versions: Mapping[str, str]
    host: str
    sees: bool


class DaskBackend(DaskDistributedBackend):  # type: ignore[misc]
    """Joblib's backend for Dask, except that it does not wait for ever if a task has no result."""

    def effective_n_jobs(self, n_jobs: int) -> int:
        """Return how many tasks the cluster processes at once, but at least 2: for 1, joblib would not use it."""
        return max(2, int(super().effective_n_jobs(n_jobs)))

    async def _collect(self) -> None:
        while self._continue:
            async for future, result in self.waiting_futures:
                waiting, callback = self._results.pop(future), self._callbacks.pop(future)
                if future.status != "finished":
                    cause = result[1] if isinstance(result, tuple) else result
                    result = WorkersLost(one_line(cause) or future.status)
                waiting.set_result(result)
                callback(result)
            await asyncio.sleep(0.01)

    def retrieve_result_callback(self, out: Any) -> Any:
        """Return the result of a task, or raise an error if the task lost its workers."""
        if isinstance(out, WorkersLost):
            raise out
        return super().retrieve_result_callback(out)


@contextlib.contextmanager
def connected(address: str) -> Iterator[Any]:
    """Connect to a scheduler of Dask; yield the `distributed.Client`."""
    try:
        from distributed import Client
    except ImportError as error:
        raise InputError(f"runner=dask needs a package that is not installed. Install it: {_INSTALL}") from error
    for name in _CHATTY:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        client = Client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(
            f"No Dask scheduler answers at runner.address={without_secrets(address)}. Start one with 'dask scheduler', "
            "and its workers with 'dask worker ADDRESS'."
        ) from error
    with client:
        yield client


def survey(client: Any, address: str, file: Path) -> dict[str, Site]:
    """Ask every worker for its versions, its host and whether it sees a file; return the answers by worker address."""
    sites: dict[str, Any] = client.run(site, str(file), on_error="return")
    if not sites:
        shown = without_secrets(address)
        raise InputError(f"The Dask scheduler at {shown} has no workers. Start some with 'dask worker {shown}'.")
    for worker, sites_found in sorted(sites.items()):
        if not isinstance(sites_found, Site):
            raise InputError(f"Worker {worker} cannot run this foundry ({sites_found}): {_same_versions()}")
        for name, version in provenance.versions().items():
            if sites_found.versions.get(name) != version:
                other = sites_found.versions.get(name, "none")
                raise InputError(f"Worker {worker} has {name} {other}, this process has {version}: {_same_versions()}")
    return sites


def _same_versions() -> str:
    return "install the same versions on both, because versions can change records."


def site(file: str) -> Site:
    """Run on a worker of the cluster: return its versions, its host, and whether the file exists there."""
    return Site(provenance.versions(), socket.gethostname(), Path(file).exists())


def scheduler_lost() -> Callable[[], bool]:
    """Return a function that tells whether this worker has lost its connection to the scheduler, and so to the command.

    A worker without a scheduler would still finish its tasks, whose calls cost money.
    """
    from distributed import Status, get_worker

    worker = get_worker()
    return lambda: worker.status in (Status.closing, Status.closed, Status.failed)


def check_cache(sites: Mapping[str, Site], cache: str) -> None:
    """Raise an error if several machines would write to the same answer cache and this cache is a file."""
    hosts = {site.host for site in sites.values()} | {socket.gethostname()}
    if len(hosts) > 1 and not is_database(cache):
        raise InputError(
            f"The answer cache '{cache}' is a file, which {len(hosts)} machines cannot share: "
            "set cache=postgresql://HOST/DATABASE."
        )


def check_folder(sites: Mapping[str, Site], folder: Path) -> None:
    """Raise an error if some workers cannot read the sweep's folder."""
    blind = sorted(worker for worker, site in sites.items() if not site.sees)
    if blind:
        raise InputError(
            f"Worker {blind[0]} does not see '{folder}': put output.dir where all workers see it, "
            "or send the runs to a URL with runner.remote=URL."
        )


class DaskRunner(Runner):
    """Plays the runs of a sweep on a Dask cluster, which shares a file system or sends every run to a URL."""

    def __init__(
        self,
        address: str,
        workers: int | None = None,
        open_runs: int = 16,
        remote: str | None = None,
        ahead: bool = True,
    ) -> None:
        """Check and store the settings, which `conf/runner/dask.yaml` explains."""
        super().__init__(open_runs, ahead)
        if "://" not in address:
            raise InputError(f"runner.address={address} lacks a protocol. Write, for example, tcp://{address}.")
        self._address = address
        self._workers = worker_count(workers)
        self._remote = remote

    @contextlib.contextmanager
    def at_work(self, job: SweepJob) -> Iterator[PlayPhase]:
        """Connect to the cluster, and check that its workers can run the sweep."""
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
        """Give the whole list of runs to every worker; a worker also plays runs whose worker has died."""
        spec = self.spec(job, runs, number)

        def attempt() -> str | None:
            given = [replace(spec, name=f"{spec.name}-{lane}", workers=workers) for lane in range(workers)]
            tasks = [joblib.delayed(work)(spec) for spec in given]
            return next(filter(None, list(_parallel(client, tasks, at_once="all"))), None)

        workers = self._size(client, runs)
        raise_if_stopped(self._outlive(client, attempt, runs), job)

    def _play_remotely(
        self, client: Any, job: SweepJob, remote: RemoteRuns, runs: Sequence[RunFolder], number: int
    ) -> None:
        """Give each worker chunks of runs that no other worker gets, and fetch the played runs from the URL."""
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
        """Repeat `attempt` after workers died, as long as at least one further run ended since the last repetition."""
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
    """Play runs on a machine of the cluster; return the cause that must end the sweep, or None."""
    return Lanes(spec, 1, scheduler_lost()).run()


def play(chunk: Chunk) -> Played:
    """Play a chunk of runs on a machine of the cluster."""
    return play_chunk(chunk, scheduler_lost())


def _parallel(client: Any, tasks: Iterable[Any], at_once: int | str) -> Iterator[Any]:
    with joblib.parallel_config(backend=DaskBackend(client=client)):
        parallel = joblib.Parallel(n_jobs=-1, batch_size=1, pre_dispatch=at_once, return_as="generator_unordered")
        yield from parallel(tasks)
