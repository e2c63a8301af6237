"""What a run's files hold is what was written, whole, and of this start alone."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from foundry.errors import StorageError
from foundry.storing.run_files import write_atomically
from foundry.storing.run_writer import RunWriter
from foundry.storing.store import RunFolder
from made_up_runs import call, step, sweep

resource = pytest.importorskip("resource", reason="sets the limits of a process")


@pytest.fixture
def folder(tmp_path: Path) -> RunFolder:
    return sweep(tmp_path / "sweep").runs()[0]


@contextmanager
def largest_file(size: int) -> Iterator[None]:
    """Have the system take this many bytes a file and no more: a write that goes beyond takes a part at first."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)


def test_a_line_of_which_the_disk_takes_a_part_ends_the_sweep(folder: RunFolder):
    writer = RunWriter(folder, "")
    records = [step(1, 0), step(1, 1)]
    with largest_file(100), pytest.raises(StorageError, match="steps.jsonl"):
        writer.append(records)
    assert len(folder.steps_bytes()) == 100
    writer.close()


def test_a_file_of_which_the_disk_takes_a_part_stays_as_it_was_and_leaves_nothing_beside_it(tmp_path: Path):
    write_atomically(tmp_path / "run.json", b"before")
    with largest_file(100), pytest.raises(OSError, match="File too large"):
        write_atomically(tmp_path / "run.json", b"x" * 101)
    assert {file.name: file.read_bytes() for file in tmp_path.iterdir()} == {"run.json": b"before"}


def test_a_run_that_is_started_anew_keeps_nothing_of_its_last_start(folder: RunFolder):
    first = RunWriter(folder, "")
    first.append([step(1, 0), step(1, 1)])
    first.frame(1, b"png")
    first.close()
    for name in ("images/step_0001.png", "episode.jsonl", "run.json"):
        (folder.path / name).parent.mkdir(exist_ok=True)
        (folder.path / name).write_bytes(b"old")
    assert folder.pictures() == ["frames/step_0001.png", "images/step_0001.png"]
    again = RunWriter(folder, "")
    again.append([step(1, 1)])
    again.close()
    assert folder.pictures() == [] and not folder.ended and folder.episode_bytes() == b""
    assert folder.steps_bytes().count(b"\n") == 1


def test_who_sees_that_a_run_was_started_anew_finds_nothing_of_before(
    folder: RunFolder, monkeypatch: pytest.MonkeyPatch
):
    first = RunWriter(folder, "")
    first.append([step(1, 0)])
    first.append_calls([call(step(1, 0), "action", "go", "")])
    first.close()
    found: list[bytes] = []

    def seen(path: Path, content: bytes) -> None:
        found.extend((folder.steps_bytes(), (folder.path / "calls.jsonl.zst").read_bytes()))
        write_atomically(path, content)

    monkeypatch.setattr("foundry.storing.run_writer.write_atomically", seen)
    RunWriter(folder, "").close()
    assert found == [b"", b""]
