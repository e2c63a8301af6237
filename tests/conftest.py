"""Shared fixtures: a clean environment, an empty working directory, and no network but this machine's."""

from __future__ import annotations

import gc
import os
import signal
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings
from xdist.scheduler import LoadScopeScheduling

from postgres_server import PostgresServer, postgres_server, programs
from traces import no_traces, without_settings

gc.set_threshold(50_000, 50, 50)  # hundreds of thousands of objects live here, most of them from imports
os.environ.setdefault("LP_NUM_THREADS", "0")  # two test processes draw faster with a core each
SETTINGS = {
    "FOUNDRY_WORKERS": "1",  # starting processes takes longer than most sweeps of tests
    "FOUNDRY_DETERMINISM": "0",  # tests count the calls of their servers
    "FOUNDRY_CANARY": "false",
}
signal.signal(signal.SIGINT, signal.default_int_handler)  # in the background it is ignored, by children too
os.environ.update(SETTINGS)  # for what is made once for all tests of a session
_OWN_FILES = tempfile.TemporaryDirectory(prefix="foundry-tests-")
os.environ["XDG_CONFIG_HOME"] = _OWN_FILES.name  # no test sees the defaults of whoever runs it
settings.register_profile("foundry", deadline=None, max_examples=20, derandomize=True)
settings.load_profile("foundry")


class FolderScheduling(LoadScopeScheduling):
    """Gives a folder of tests to one worker, so that what its tests share is made once."""

    def _split_scope(self, nodeid: str) -> str:
        return nodeid.partition("::")[0].rpartition("/")[0]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> FolderScheduling | None:
    """Return the schedule by folder, unless another was asked for."""
    return FolderScheduling(config, log) if config.getoption("dist") == "loadscope" else None


def pytest_unconfigure() -> None:
    _OWN_FILES.cleanup()


def pytest_collection_finish(session: pytest.Session) -> None:
    """Leave what was imported and collected out of every later look for garbage, and write no more bytecode.

    Tests write modules anew within a second, which bytecode would not notice.
    """
    gc.freeze()
    sys.dont_write_bytecode = True
    os.environ["PYTHONDONTWRITEBYTECODE"] = "1"


@pytest.fixture(autouse=True)
def clean_environment() -> Iterator[None]:
    with no_traces():
        without_settings()
        os.environ.update(SETTINGS)
        yield


@pytest.fixture
def workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="session")
def postgres() -> Iterator[PostgresServer]:
    pytest.importorskip("psycopg", reason="needs the extra postgres: pip install 'foundry-worlds[postgres]'")
    installed = programs()
    if installed is None:
        pytest.skip("needs PostgreSQL: apt-get install postgresql")
    with postgres_server(installed) as server:
        yield server
