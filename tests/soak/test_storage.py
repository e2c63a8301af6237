"""A disk that is full, a cache that is damaged: one clear line, and nothing lost."""

import contextlib
import os
import shutil
import sqlite3
from pathlib import Path

import pytest

from analysis import analyze
from commands import calls, foundry, records, statuses, succeeds
from full_disk import no_file_beyond
from ollama_server import OllamaServer

SCRIPTED = ("model=scripted/echo", "world.agents=8", "world.steps=12", "runner.workers=1", "analyze=false")
SERVED = (
    *("-m", "model=qwen3:4b", "seed=0-3", "world.agents=2", "world.steps=3", "runner.workers=1", "analyze=false"),
    *("model.server.retry.wait_initial_s=0.01", "model.server.retry.wait_max_s=0.1"),
)


def cause(output: str) -> str:
    assert "Traceback" not in output
    (line,) = output.splitlines()
    return line


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder in which the served sweep was run undisturbed."""
    folder = tmp_path_factory.mktemp("whole")
    with OllamaServer() as server:
        succeeds(*SERVED, "output.dir=whole", cwd=folder, OLLAMA_HOST=server.url)
    return folder


def test_a_run_that_fills_the_disk_stops_the_sweep_and_goes_on_later(tmp_path: Path):
    succeeds(*SCRIPTED, "output.dir=whole", cwd=tmp_path)
    largest = max(file.stat().st_size for file in (tmp_path / "whole").rglob("*.jsonl"))
    with no_file_beyond(largest // 2):
        full = foundry(*SCRIPTED, "output.dir=out", cwd=tmp_path)
    assert full.returncode == 3 and "steps.jsonl' cannot be written (EFBIG" in cause(full.stderr)
    assert "foundry resume" in full.stderr and statuses(tmp_path / "out") == [None]
    assert not list((tmp_path / "out").rglob("*.tmp"))
    succeeds("resume", "out", cwd=tmp_path)
    assert records(tmp_path / "out") == records(tmp_path / "whole")


def test_a_disk_that_is_full_from_the_start_is_one_line(tmp_path: Path):
    with no_file_beyond(100):
        full = foundry(*SCRIPTED, "output.dir=out", cwd=tmp_path)
    assert full.returncode == 3 and "nothing more can be written" in cause(full.stderr)
    succeeds(*SCRIPTED, "output.dir=out", cwd=tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(("command", "size"), [("analyze", 20_000), ("report", 100)])
def test_an_analysis_that_fills_the_disk_is_one_line_and_works_later(command: str, size: int, tmp_path: Path):
    succeeds(*SCRIPTED, "output.dir=out", cwd=tmp_path)
    with no_file_beyond(size):
        full = foundry(command, "out", cwd=tmp_path)
    assert full.returncode == 3 and "nothing more can be written" in cause(full.stderr)
    assert len(analyze(tmp_path / "out", plots=False).runs) == 1


@pytest.mark.exhaustive
def test_a_cache_that_cannot_grow_stops_the_sweep_before_every_answer_is_paid_for_nothing(tmp_path: Path):
    with OllamaServer() as server:
        with no_file_beyond(60_000):
            full = foundry(*SERVED, "output.dir=out", cwd=tmp_path, OLLAMA_HOST=server.url)
        assert full.returncode == 3 and "answers.sqlite' cannot be used" in cause(full.stderr)
        lost = len(server.answered)
        succeeds("resume", "out", cwd=tmp_path)
    assert lost < len(server.answered)
    assert set(statuses(tmp_path / "out")) == {"complete"}


@pytest.mark.slow
@pytest.mark.parametrize(
    "damage",
    ["cut", pytest.param("noise", marks=pytest.mark.exhaustive), pytest.param("emptied", marks=pytest.mark.exhaustive)],
)
def test_a_damaged_cache_is_named_or_asked_anew_and_ends_no_run_wrongly(damage: str, whole: Path, tmp_path: Path):
    cache = tmp_path / "outputs" / "answers.sqlite"
    cache.parent.mkdir()
    shutil.copyfile(spoiled(whole, damage), cache)
    with OllamaServer() as server:
        done = foundry(*SERVED, "output.dir=out", cwd=tmp_path, OLLAMA_HOST=server.url)
        if done.returncode != 0:
            assert done.returncode == 3 and "answers.sqlite' cannot be used" in cause(done.stderr)
            assert set(statuses(tmp_path / "out")) <= {None, "complete"}
            shutil.move(cache, tmp_path / "damaged")
            succeeds("resume", "out", cwd=tmp_path)
    assert records(tmp_path / "out") == records(whole / "whole")
    assert calls(tmp_path / "out") == calls(whole / "whole")


def spoiled(folder: Path, damage: str) -> Path:
    """Return a damaged copy of the cache in a folder."""
    cache = folder / damage
    with contextlib.closing(sqlite3.connect(folder / "outputs" / "answers.sqlite")) as database:
        database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    shutil.copyfile(folder / "outputs" / "answers.sqlite", cache)
    size = cache.stat().st_size
    if damage == "noise":
        with cache.open("r+b") as file:
            for page in range(1, size // 4096):
                file.seek(page * 4096 + 2000)
                file.write(b"\xa5" * 300)
    else:
        os.truncate(cache, size // 2 if damage == "cut" else 0)
    return cache
