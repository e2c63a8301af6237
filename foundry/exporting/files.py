"""What a writer of a format hands back."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Files:
    """What was written.

    Attributes:
        paths: the files.
        notes: what was left out, and why, one line each.
    """

    paths: tuple[Path, ...]
    notes: tuple[str, ...] = ()
