"""What is read of a run's files, whole, cut or spoiled."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from foundry.errors import RecordError
from foundry.storing.run_files import PROBE, calls_bytes, kept_file, last_whole_step, moments_here, read_calls
from foundry.storing.store import RunFolder
from made_up_runs import Playing, sweep, whole_run


@pytest.fixture
def folder(tmp_path: Path) -> RunFolder:
    return sweep(tmp_path / "sweep").runs()[0]


def test_only_runs_that_failed_are_started_again(tmp_path: Path):
    complete, failed, open_, _ = runs = sweep(tmp_path / "sweep").runs()
    whole_run(complete)
    Playing(failed).end("the server is gone")
    Playing(open_).writer.close()
    assert [run.ended for run in runs] == [True, True, False, False]
    for run in runs:
        run.forget_failure()
    assert [run.ended for run in runs] == [True, False, False, False]


@pytest.mark.parametrize(
    ("numbers", "cut", "complete"),
    [([], 0, 0), ([1], 1, 1), ([1, 1, 2, 2], 2, 2), ([1, 1, 2], 1, 2), ([1, 1, 1, 2, 2, 3], 2, 3), ([4, 4, 5], 4, 5)],
)
def test_a_step_is_whole_with_as_many_lines_as_the_first_or_in_a_complete_run(
    numbers: list[int], cut: int, complete: int
):
    found = [last_whole_step(numbers, complete=ended) for ended in (False, True)]
    assert found == [cut, complete]


def test_a_run_tells_when_any_of_its_files_was_written_anew(folder: RunFolder):
    assert folder.stamp() == ""
    whole_run(folder)
    stamps = {folder.stamp()}
    for name in ("run.json", "steps.jsonl", "messages.jsonl", "agents.jsonl", "calls.jsonl.zst"):
        os.utime(folder.path / name, ns=(1, 1))
        stamps.add(folder.stamp())
        with (folder.path / name).open("ab") as file:
            file.write(b"\n")
        os.utime(folder.path / name, ns=(1, 1))
        stamps.add(folder.stamp())
    assert len(stamps) == 11


def test_only_a_probe_reads_moments_that_lie_in_its_sweep(folder: RunFolder):
    assert folder.config() == folder.recorded_config()
    kept = moments_here({"world": {"_target_": PROBE}}, folder.path)["world"]["kept"]
    assert kept["moments"] == str(folder.path / "moments.json") and "{run}" in kept["past"]


def test_the_file_that_says_that_a_run_ended_is_handed_on_last(folder: RunFolder):
    whole_run(folder)
    names = [file.name for file in folder.files()]
    assert names[-1] == "run.json" and names[:-1] == sorted(set(names) - {"run.json"}) and "steps.jsonl" in names


def test_a_picture_is_read_from_the_folder_of_its_run_alone(folder: RunFolder):
    playing = Playing(folder)
    playing.writer.frame(1, b"png")
    playing.end()
    (folder.path.parent / "other.png").write_bytes(b"other")
    (folder.path / "frames" / "linked.png").symlink_to(folder.path.parent / "other.png")
    assert kept_file(folder.path, "frames/step_0001.png") == b"png"
    assert kept_file(folder.path, "frames/step_0002.png") is None
    for name in ("../other.png", str(folder.path.parent / "other.png"), "frames/linked.png", "frames", "\0"):
        with pytest.raises(RecordError, match="cannot be read|refused"):
            kept_file(folder.path, name)


def test_of_a_log_that_was_cut_or_spoiled_the_calls_before_are_read(folder: RunFolder):
    path = folder.stream_file("calls")
    assert list(read_calls(path)) == []
    whole_run(folder)
    whole, calls = path.read_bytes(), list(folder.calls())
    lengths = []
    for size in range(0, len(whole), 9):
        path.write_bytes(whole[:size] + b"\xff" * 99)
        assert list(folder.calls()) in (calls[:end] for end in range(len(calls)))
        path.write_bytes(whole[:size])
        lengths.append(len(found := list(folder.calls())))
        assert found == calls[: len(found)]
    assert lengths == sorted(lengths) and len(set(lengths)) > 10
    path.write_bytes(calls_bytes([*calls, {"step": 1}]))  # type: ignore[list-item]
    with pytest.raises(RecordError, match="cannot be read"):
        list(folder.calls())
