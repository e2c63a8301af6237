"""Shared fixtures: a clean environment, an empty working directory, and no network but this machine's."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import settings

from postgres_server import PostgresServer, postgres_server, programs

gc.set_threshold(20_000, 20, 20)  # hundreds of thousands of objects live here, most of them from imports
os.environ.setdefault("LP_NUM_THREADS", "0")  # two test processes draw faster with a core each
os.environ["FOUNDRY_DETERMINISM"] = "0"  # for what is made once for all tests of a session
settings.register_profile("foundry", deadline=None, max_examples=20, derandomize=True)
settings.load_profile("foundry")

PREFIXES = ("OLLAMA_", "OPENAI_", "HF_", "FOUNDRY_", "HYDRA_", "_FOUNDRY")


def pytest_collection_finish(session: pytest.Session) -> None:
    """Leave what was imported and collected out of every later look for garbage."""
    gc.freeze()


@pytest.fixture(autouse=True)
def clean_environment(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    for name in list(os.environ):
        if name == "_FOUNDRY_RENDERING_WORKS":  # what one test found out, the next need not
            continue
        if name.startswith(PREFIXES) or name.lower().endswith("_proxy"):
            monkeypatch.delenv(name)
    monkeypatch.setenv("FOUNDRY_WORKERS", "1")  # starting processes takes longer than most sweeps of tests
    monkeypatch.setenv("FOUNDRY_DETERMINISM", "0")  # tests count the calls of their servers
    yield


@pytest.fixture
def workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture(scope="session")
def postgres() -> Iterator[PostgresServer]:
    """A PostgreSQL server of this session's own."""
    pytest.importorskip("psycopg", reason="needs the extra postgres: pip install 'foundry-worlds[postgres]'")
    installed = programs()
    if installed is None:
        pytest.skip("needs PostgreSQL: apt-get install postgresql")
    with postgres_server(installed) as server:
        yield server
