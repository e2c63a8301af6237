"""A Dask cluster and a PostgreSQL server of the tests' own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from commands import SMALL, foundry
from dask_servers import Cluster, dask_cluster
from ollama_server import OllamaServer
from postgres_server import PostgresServer

SWEEP = ("-m", "model=qwen3:4b", "seed=0-5", *SMALL)


@pytest.fixture
def scheduler(tmp_path: Path) -> Iterator[Cluster]:
    """A cluster of a test's own, without workers."""
    pytest.importorskip("distributed", reason="needs the extra dask: pip install 'foundry-worlds[dask]'")
    folder = tmp_path / "cluster"
    folder.mkdir()
    with dask_cluster(folder) as running:
        yield running


@pytest.fixture
def mortal(scheduler: Cluster) -> Cluster:
    """A cluster of a test's own with three workers, two of which stay dead when they are killed."""
    scheduler.add(2)
    scheduler.add(1, nanny=True)
    return scheduler


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """A cluster with three workers, one of them with a nanny, that nobody kills."""
    pytest.importorskip("distributed", reason="needs the extra dask: pip install 'foundry-worlds[dask]'")
    with dask_cluster(tmp_path_factory.mktemp("cluster")) as running:
        running.add(2)
        running.add(1, nanny=True)
        yield running


@pytest.fixture
def cache(postgres: PostgresServer) -> str:
    """The override that names an empty database."""
    return f"cache={postgres.database()}"


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sweep as the plain command runs it on this machine."""
    workspace = tmp_path_factory.mktemp("undisturbed")
    with OllamaServer() as server:
        done = foundry(*SWEEP, "output.dir=sweep", "runner.workers=1", cwd=workspace, OLLAMA_HOST=server.url)
    assert done.returncode == 0, done.stdout + done.stderr
    return workspace / "sweep"
