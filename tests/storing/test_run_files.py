"""What is read of a run and of notes, whole, cut or spoiled, is what was written."""

import os
import threading
from pathlib import Path
from typing import Any

import msgspec
import pytest

from foundry.errors import InputError, RecordError, StorageError
from foundry.storing.notes import NOTES_FILE, Note, add_note, notes_bytes, notes_of, stamp_of_notes
from foundry.storing.run_files import (
    PROBE,
    calls_bytes,
    last_whole_step,
    moments_here,
    read_calls,
    stored_picture,
    write_atomically,
)
from foundry.storing.run_writer import RunWriter
from foundry.storing.store import RunFolder
from full_disk import no_file_beyond
from made_up_runs import Playing, call, step, sweep, whole_run


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
    assert stored_picture(folder.path, "frames/step_0001.png") == b"png"
    assert stored_picture(folder.path, "frames/step_0002.png") is None
    for name in ("../other.png", str(folder.path.parent / "other.png"), "frames/linked.png", "frames", "\0"):
        with pytest.raises(RecordError, match="cannot be read|refused"):
            stored_picture(folder.path, name)


def test_of_a_log_that_was_cut_or_spoiled_the_calls_before_are_read(folder: RunFolder):
    path = folder.stream_file("calls")
    assert list(read_calls(path)) == []
    whole_run(folder)
    whole, calls = path.read_bytes(), list(folder.calls())
    lengths = []
    for size in range(0, len(whole), 31):
        path.write_bytes(whole[:size] + b"\xff" * 99)
        assert list(folder.calls()) in (calls[:end] for end in range(len(calls)))
        path.write_bytes(whole[:size])
        lengths.append(len(found := list(folder.calls())))
        assert found == calls[: len(found)]
    assert lengths == sorted(lengths) and len(set(lengths)) > 10
    long = [msgspec.structs.replace(call, text=f"{number}, " * 20_000) for number, call in enumerate(calls)]
    path.write_bytes(calls_bytes(long))
    assert list(folder.calls()) == long
    path.write_bytes(calls_bytes([*calls, {"step": 1}]))  # type: ignore[list-item]
    with pytest.raises(RecordError, match="cannot be read"):
        list(folder.calls())


def test_a_line_of_which_the_disk_takes_a_part_ends_the_sweep(folder: RunFolder):
    writer = RunWriter(folder, "")
    records = [step(1, 0), step(1, 1)]
    with no_file_beyond(100), pytest.raises(StorageError, match="steps.jsonl"):
        writer.append(records)
    assert len(folder.steps_bytes()) == 100
    writer.close()


def test_a_file_of_which_the_disk_takes_a_part_stays_as_it_was_and_leaves_nothing_beside_it(tmp_path: Path):
    write_atomically(tmp_path / "run.json", b"before")
    with no_file_beyond(100), pytest.raises(OSError, match="File too large"):
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
    assert [call.text for call in folder.calls()] == ["go"], "it can be read before the run has ended"
    first.close()
    found: list[bytes] = []

    def seen(path: Path, content: bytes) -> None:
        found.extend((folder.steps_bytes(), (folder.path / "calls.jsonl.zst").read_bytes()))
        write_atomically(path, content)

    monkeypatch.setattr("foundry.storing.run_writer.write_atomically", seen)
    RunWriter(folder, "").close()
    assert found == [b"", b""]


def note(name: str, text: str = "odd", **keys: Any) -> Note:
    given: dict[str, Any] = {
        "when": "2026-01-01T00:00:00+00:00",
        "who": "Ada",
        "run": "run-1",
        "step": 3,
        "agent": None,
    }
    return Note(note=name, text=text, **{**given, "tags": ("odd",), **keys})


def test_a_later_line_changes_or_ends_a_note_and_the_file_keeps_all(tmp_path: Path):
    for line in (note("a"), note("b"), note("a", "odder"), note("b", deleted=True)):
        add_note(tmp_path, line)
    assert notes_of(tmp_path).notes == [note("a", "odder")]
    assert len((tmp_path / NOTES_FILE).read_bytes().splitlines()) == 4
    assert notes_bytes(notes_of(tmp_path).notes) == msgspec.json.encode(note("a", "odder")) + b"\n"


def test_a_line_that_a_crash_cut_is_told_and_the_next_begins_anew(tmp_path: Path):
    add_note(tmp_path, note("a"))
    file = tmp_path / NOTES_FILE
    file.write_bytes(file.read_bytes() + msgspec.json.encode(note("b"))[:40])
    notes = notes_of(tmp_path)
    assert notes.notes == [note("a")] and len(notes.unread) == 1
    assert notes.unread[0].startswith("Line 2 of notes.jsonl is left out: ")
    add_note(tmp_path, note("c"))
    notes = notes_of(tmp_path)
    assert notes.notes == [note("a"), note("c")] and len(notes.unread) == 1


def test_many_who_write_at_once_lose_nothing(tmp_path: Path):
    def write(writer: int) -> None:
        for number in range(5):
            add_note(tmp_path, note(f"{writer}-{number}", "x" * 9000))

    writers = [threading.Thread(target=write, args=(writer,)) for writer in range(4)]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    notes = notes_of(tmp_path)
    assert (len(notes.notes), notes.unread) == (20, [])


def test_nothing_is_noted_where_nobody_did(tmp_path: Path):
    assert notes_of(tmp_path).notes == [] and stamp_of_notes(tmp_path) == ""
    add_note(tmp_path, note("a"))
    first = stamp_of_notes(tmp_path)
    add_note(tmp_path, note("b"))
    assert first and stamp_of_notes(tmp_path) != first


def test_where_nothing_can_be_written_is_told(tmp_path: Path):
    (tmp_path / "viewer").write_bytes(b"")
    with pytest.raises(InputError, match=r"The note cannot be written into '.*notes\.jsonl'"):
        add_note(tmp_path, note("a"))
