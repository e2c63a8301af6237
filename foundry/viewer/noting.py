"""Takes the notes that people write on the page."""

from __future__ import annotations

import datetime
import secrets

import msgspec

from foundry.errors import InputError, not_found
from foundry.storing.notes import Note, add_note, notes_of
from foundry.viewer.catalog import CatalogedSweep


class _Written(msgspec.Struct, forbid_unknown_fields=True):
    """What the page sends: a new note, or one that is there, named, as it is to be."""

    who: str
    run: str
    step: int | None
    agent: int | None
    text: str
    tags: tuple[str, ...]
    note: str | None = None
    deleted: bool = False


def take_note(sweep: CatalogedSweep, content: bytes) -> None:
    """Add a note, or write one anew.

    Raises:
        InputError: there is no such run or note, or it says nothing, or not what a note says.
    """
    try:
        written = msgspec.json.decode(content, type=_Written)
        now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
        named = {"note": written.note or secrets.token_hex(6), "when": now}
        note = msgspec.convert({**msgspec.to_builtins(written), **named}, Note)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise InputError(f"The note cannot be read: {error}") from error
    sweep.run(note.run)
    known = [one.note for one in notes_of(sweep.folder.path).notes]
    if written.note is not None and written.note not in known:
        raise not_found("Note", written.note, known)
    if not (note.text.strip() or note.tags or note.deleted):
        raise InputError("A note says something: write a text or a tag.")
    add_note(sweep.folder.path, note)
