"""A Dask cluster that exists already: the connection, what its workers are, joblib's way to give them work."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import socket
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from joblib._dask import DaskDistributedBackend

from foundry import provenance
from foundry.errors import FoundryError, InputError
from foundry.models.answers.addresses import is_database
from foundry.texts import without_secrets

CONNECT_S = 5
_CHATTY = ("distributed", "distributed.client", "distributed.core", "distributed.comm")
"""What these log of lost connections, with tracebacks, is told in one line here."""
_INSTALL = "pip install 'foundry-worlds[dask]'"


class WorkersLost(FoundryError):
    """A task ended without a result, since the workers that had it died, or the scheduler did."""


@dataclass(frozen=True)
class Site:
    """What a worker of the cluster says of itself.

    Attributes:
        versions: of foundry, Python and the packages that can change a record.
        host: the machine.
        sees: whether it sees the file that it was asked about.
    """

    versions: Mapping[str, str]
    host: str
    sees: bool


class DaskBackend(DaskDistributedBackend):  # type: ignore[misc]
    """Joblib's backend, which would wait forever for a task that has no result."""

    def effective_n_jobs(self, n_jobs: int) -> int:
        """Return how many tasks the cluster works on at once; never 1, for which joblib would not ask the cluster."""
        return max(2, int(super().effective_n_jobs(n_jobs)))

    async def _collect(self) -> None:
        while self._continue:
            async for future, result in self.waiting_futures:
                waiting, callback = self._results.pop(future), self._callbacks.pop(future)
                if future.status != "finished":
                    cause = result[1] if isinstance(result, tuple) else result
                    result = WorkersLost(" ".join(str(cause).split()) or future.status)
                waiting.set_result(result)
                callback(result)
            await asyncio.sleep(0.01)

    def retrieve_result_callback(self, out: Any) -> Any:
        """Return a task's result.

        Raises:
            WorkersLost: it has none.
        """
        if isinstance(out, WorkersLost):
            raise out
        return super().retrieve_result_callback(out)


@contextlib.contextmanager
def connected(address: str) -> Iterator[Any]:
    """Connect to a scheduler; yields the `distributed.Client`.

    Raises:
        InputError: the extra is not installed, or no scheduler answers.
    """
    try:
        from distributed import Client
    except ImportError as error:
        raise InputError(f"runner=dask needs a package that is not installed: {_INSTALL}") from error
    for name in _CHATTY:
        logging.getLogger(name).setLevel(logging.CRITICAL + 1)
    try:
        client = Client(address, timeout=CONNECT_S, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(
            f"No Dask scheduler answers at runner.address={without_secrets(address)}: start one with 'dask scheduler', "
            "and workers with 'dask worker ADDRESS'."
        ) from error
    with client:
        yield client


def survey(client: Any, address: str, file: Path) -> dict[str, Site]:
    """Ask every worker what it is and whether it sees a file; returns the answers by the workers' addresses.

    Raises:
        InputError: there is no worker, or one cannot do foundry's work or has other versions than this process.
    """
    sites: dict[str, Any] = client.run(site, str(file), on_error="return")
    if not sites:
        shown = without_secrets(address)
        raise InputError(f"The Dask scheduler at {shown} has no workers: start some with 'dask worker {shown}'.")
    for worker, found in sorted(sites.items()):
        if not isinstance(found, Site):
            raise InputError(f"Worker {worker} cannot run this foundry ({found}): {_same_versions()}")
        for name, version in provenance.versions().items():
            if found.versions.get(name) != version:
                other = found.versions.get(name, "none")
                raise InputError(f"Worker {worker} has {name} {other}, this process has {version}: {_same_versions()}")
    return sites


def _same_versions() -> str:
    return "install the same versions on both, since they decide what is recorded."


def site(file: str) -> Site:
    """Return what this process is; called on the workers."""
    return Site(provenance.versions(), socket.gethostname(), Path(file).exists())


def scheduler_lost() -> Callable[[], bool]:
    """Return what says, on a worker of the cluster, whether it has lost its scheduler and with it the command.

    Such a worker ends, but only once its tasks have; what they play would go on being paid for.
    """
    from distributed import Status, get_worker

    worker = get_worker()
    return lambda: worker.status in (Status.closing, Status.closed, Status.failed)


def check_cache(sites: Mapping[str, Site], cache: str) -> None:
    """Refuse a cache in a file where several machines would write to it.

    Raises:
        InputError: it is one.
    """
    hosts = {site.host for site in sites.values()} | {socket.gethostname()}
    if len(hosts) > 1 and not is_database(cache):
        raise InputError(
            f"The answer cache '{cache}' is a file, which {len(hosts)} machines cannot share: "
            "set cache=postgresql://HOST/DATABASE."
        )


def check_folder(sites: Mapping[str, Site], folder: Path) -> None:
    """Refuse a sweep's folder that not all workers see.

    Raises:
        InputError: one does not.
    """
    blind = sorted(worker for worker, site in sites.items() if not site.sees)
    if blind:
        raise InputError(
            f"Worker {blind[0]} does not see '{folder}': put output.dir where all workers see it, "
            "or send the runs to a URL with runner.remote=URL."
        )
