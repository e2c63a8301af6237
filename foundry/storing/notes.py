"""The notes that people write about runs and moments (`notes.jsonl`); lines are only added."""

import os
from pathlib import Path
from typing import Annotated

import msgspec
from filelock import FileLock, Timeout

from foundry.errors import InputError
from foundry.records import NOT_JSON
from foundry.storing.plain import is_there, stamp_of

NOTES_FILE = "notes.jsonl"
_LOCK = "notes.lock"
_PATIENCE_S = 10.0
Tag = Annotated[str, msgspec.Meta(max_length=40, pattern=r"^[^\s,]+$")]
Place = Annotated[int, msgspec.Meta(ge=0)]


class Note(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A line of `notes.jsonl`; a later line with the same id replaces an earlier one.

    Attributes:
        note: id of the note.
        who: name that the author entered.
        run: id of the run; in a probe, id of the run that the moment comes from.
        step: the step, or null for the whole run.
        agent: the agent, or null for all agents.
        text: the text; it may be empty if the note has tags.
        tags: single words.
        moment: in a probe, index of the moment in the list of moments; else null.
        deleted: whether the author deleted the note.
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
        """The place of the note in words, as in "step 3 · agent 0"."""
        if self.step is None:
            return "the run"
        return f"step {self.step}" if self.agent is None else f"step {self.step} · agent {self.agent}"


class Notes(msgspec.Struct, frozen=True):
    """The notes of a sweep.

    Attributes:
        notes: the latest version of each note that is not deleted, oldest note first.
        unread: for each line that could not be read, the reason.
    """

    notes: list[Note]
    unread: list[str]


def notes_of(folder: Path) -> Notes:
    """Return the notes in a sweep's folder; unreadable lines, for example cut by a crash, are left out and reported."""
    file, notes, unread = folder / NOTES_FILE, dict[str, Note](), list[str]()
    content = file.read_bytes() if is_there(file) else b""
    for number, line in enumerate(content.splitlines(), 1):
        try:
            note = msgspec.json.decode(line, type=Note) if line else None
        except NOT_JSON as error:
            unread.append(f"Line {number} of {NOTES_FILE} is left out: {error}")
        else:
            if note is not None:
                notes[note.note] = note
    return Notes([note for note in notes.values() if not note.deleted], unread)


def stamp_of_notes(folder: Path) -> str:
    """Return a text that changes whenever a note is added or changed; "" without notes."""
    return stamp_of(folder / NOTES_FILE)


def add_note(folder: Path, note: Note) -> None:
    """Add a line to the notes of a sweep; if a crash cut the last line, the new line begins after a line break."""
    file = folder / NOTES_FILE
    line = msgspec.json.encode(note) + b"\n"
    try:
        (folder / "viewer").mkdir(exist_ok=True)
        with FileLock(folder / "viewer" / _LOCK, timeout=_PATIENCE_S), file.open("a+b") as lines:
            if lines.tell():
                lines.seek(-1, os.SEEK_END)
                line = line if lines.read(1) == b"\n" else b"\n" + line
            lines.write(line)
            lines.flush()
            os.fsync(lines.fileno())
    except (OSError, Timeout) as error:
        raise InputError(f"The note cannot be written into '{file}': {error}") from error


def notes_bytes(notes: list[Note]) -> bytes:
    """Return notes as the content of a file, with one line for each note."""
    return msgspec.json.Encoder().encode_lines(notes)
