"""How often a sweep was looked at (`looks.jsonl`): which pairs of groups were tested, with how many seeds."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import msgspec

from foundry.storing.plain import is_there
from foundry.storing.run_files import lines_of, write_atomically

LOOKS_FILE = "looks.jsonl"


class LookedAt(msgspec.Struct, frozen=True, kw_only=True):
    """A pair of groups at a look, a line of the file.

    Attributes:
        factor: the setting in which they differ.
        level: its value in the first group.
        reference: its value in the second.
        context: what else was swept and is equal in both.
        pairs: seeds with a value in both.
        at: when they were looked at first, UTC.
        settings: hashes of the settings of both, sorted: they stay when another setting is swept. Empty in older files.
    """

    factor: str
    level: str
    reference: str
    context: str
    pairs: int
    at: str
    settings: tuple[str, ...] = ()


def looks_of(folder: Path) -> list[LookedAt]:
    """Return all looks at a sweep, the first first.

    Raises:
        RecordError: the file cannot be read.
    """
    file = folder / LOOKS_FILE
    return lines_of(file.read_bytes(), LookedAt, file) if is_there(file) else []


def write_looks(folder: Path, looks: Sequence[LookedAt]) -> None:
    """Keep the looks at a sweep."""
    write_atomically(folder / LOOKS_FILE, msgspec.json.Encoder().encode_lines(looks))
