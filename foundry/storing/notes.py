"""People's notes on runs and moments (`notes.jsonl`), outside the records; lines are only added."""

import os
from pathlib import Path
from typing import Annotated

import msgspec
from filelock import FileLock, Timeout

from foundry.errors import InputError
from foundry.records import NOT_JSON
from foundry.storing.plain import is_there

NOTES_FILE = "notes.jsonl"
_LOCK = "notes.lock"
_PATIENCE_S = 10.0
Tag = Annotated[str, msgspec.Meta(max_length=40, pattern=r"^[^\s,]+$")]
Place = Annotated[int, msgspec.Meta(ge=0)]


class Note(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A line of the file: the content of a note from that time on.

    Attributes:
        note: id of the note, equal in all of its lines.
        when: ISO 8601, UTC.
        who: name that the author gave.
        run: the run's id; for a moment of a probe, the id of the moment's run.
        step: the step, or null for the whole run.
        text: the note; may be empty if there are tags.
        tags: single words.
        moment: index of a probe's moment in the list of moments, or null.
    """

    note: Annotated[str, msgspec.Meta(min_length=1, max_length=40)]
    when: str
    who: Annotated[str, msgspec.Meta(max_length=80)]
    run: str
    step: Place | None
    agent: Place | None
    text: Annotated[str, msgspec.Meta(max_length=10_000)]
    tags: Annotated[tuple[Tag, ...], msgspec.Meta(max_length=20)]
    moment: Place | None = None
    deleted: bool = False

    @property
    def place(self) -> str:
        """The subject of the note, in words."""
        if self.step is None:
            return "the run"
        return f"step {self.step}" if self.agent is None else f"step {self.step} · agent {self.agent}"


class Notes(msgspec.Struct, frozen=True):
    """The notes of a sweep.

    Attributes:
        notes: the latest versions of all notes that are not deleted, oldest first.
        unread: reasons for omitted lines.
    """

    notes: list[Note]
    unread: list[str]


def notes_of(folder: Path) -> Notes:
    """Return the notes of a sweep; unreadable lines, for example cut by a crash, are omitted and reported."""
    file, found, unread = folder / NOTES_FILE, dict[str, Note](), list[str]()
    content = file.read_bytes() if is_there(file) else b""
    for number, line in enumerate(content.splitlines(), 1):
        try:
            note = msgspec.json.decode(line, type=Note) if line else None
        except NOT_JSON as error:
            unread.append(f"Line {number} of {NOTES_FILE} is left out: {error}")
        else:
            if note is not None:
                found[note.note] = note
    return Notes([note for note in found.values() if not note.deleted], unread)


def stamp_of_notes(folder: Path) -> str:
    """Return a text that changes whenever a note does; empty without notes."""
    file = folder / NOTES_FILE
    if not is_there(file):
        return ""
    status = file.stat()
    return f"{status.st_mtime_ns:x}-{status.st_size:x}"


def add_note(folder: Path, note: Note) -> None:
    """Add a line; if a crash cut the last line, begin a new line first."""
    file = folder / NOTES_FILE
    line = msgspec.json.encode(note) + b"\n"
    try:
        (folder / "viewer").mkdir(exist_ok=True)
        with FileLock(folder / "viewer" / _LOCK, timeout=_PATIENCE_S), file.open("a+b") as lines:
            if lines.tell() and _last_byte(file) != b"\n":
                line = b"\n" + line
            lines.write(line)
            lines.flush()
            os.fsync(lines.fileno())
    except (OSError, Timeout) as error:
        raise InputError(f"The note cannot be written into '{file}': {error}") from error


def _last_byte(file: Path) -> bytes:
    with file.open("rb") as content:
        content.seek(-1, os.SEEK_END)
        return content.read()


def notes_bytes(notes: list[Note]) -> bytes:
    """Return the content of a file with the given notes, without earlier or deleted versions."""
    return msgspec.json.Encoder().encode_lines(notes)
