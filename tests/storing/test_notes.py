"""Notes of people: lines that are only added, the last of each note its content."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import msgspec
import pytest

from foundry.errors import InputError
from foundry.storing.notes import NOTES_FILE, Note, add_note, notes_bytes, notes_of, stamp_of_notes


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
    found = notes_of(tmp_path)
    assert found.notes == [note("a")] and len(found.unread) == 1
    assert found.unread[0].startswith("Line 2 of notes.jsonl is left out: ")
    add_note(tmp_path, note("c"))
    found = notes_of(tmp_path)
    assert found.notes == [note("a"), note("c")] and len(found.unread) == 1


def test_many_who_write_at_once_lose_nothing(tmp_path: Path):
    def write(writer: int) -> None:
        for number in range(20):
            add_note(tmp_path, note(f"{writer}-{number}", "x" * 9000))

    writers = [threading.Thread(target=write, args=(writer,)) for writer in range(4)]
    for one in writers:
        one.start()
    for one in writers:
        one.join()
    found = notes_of(tmp_path)
    assert (len(found.notes), found.unread) == (80, [])


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
