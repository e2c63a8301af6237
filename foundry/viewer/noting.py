"""Takes the notes that people write on the page."""

from __future__ import annotations

import datetime
import secrets
from collections.abc import Callable

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
    moment: int | None = None
    note: str | None = None
    deleted: bool = False


def take_note(sweep: CatalogedSweep, content: bytes, moment_of: Callable[[int], tuple[str, int, int]]) -> None:
    """Add a note, or write one anew.

    Args:
        sweep: the sweep.
        content: what the page sent.
        moment_of: returns run, step and agent of a moment of a probe, or raises InputError where there is none.

    Raises:
        InputError: there is no such run, moment or note, or it says nothing, or not what a note says.
    """
    try:
        written = msgspec.json.decode(content, type=_Written)
        now = datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")
        named = {"note": written.note or secrets.token_hex(6), "when": now}
        note = msgspec.convert({**msgspec.to_builtins(written), **named}, Note)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise InputError(f"The note cannot be read: {error}") from error
    if note.moment is None:
        sweep.run(note.run)
    elif (place := moment_of(note.moment)) != (note.run, note.step, note.agent):
        run, step, agent = place
        raise InputError(f"Moment {note.moment} is agent {agent} at step {step} of run '{run}'.")
    known = [one.note for one in notes_of(sweep.folder.path).notes]
    if written.note is not None and written.note not in known:
        raise not_found("Note", written.note, known)
    if not (note.text.strip() or note.tags or note.deleted):
        raise InputError("A note says something: write a text or a tag.")
    add_note(sweep.folder.path, note)
