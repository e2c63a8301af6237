"""Writes a sweep in the formats of other tools: each is a module of this room, imported when it is asked for."""

from __future__ import annotations

import importlib
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from foundry.errors import InputError
from foundry.exporting.shared import ExportedCondition, Files, Scores, conditions
from foundry.storing.store import SweepFolder, ensure_writable

Write: TypeAlias = Callable[[Sequence[ExportedCondition], Scores, Path], Files]
"""Writes what there is of conditions into a folder."""

_WRITERS = {"inspect": "foundry.exporting.inspect.log", "eee": "foundry.exporting.every_eval_ever.writing"}
"""The formats, and the modules whose `write` writes them; the extra that each needs has the format's name."""


@dataclass(frozen=True)
class Written:
    """What an export wrote.

    Attributes:
        path: the folder.
        files: what was written.
        runs: runs in them.
        notes: what was left out, and why, one line each.
    """

    path: Path
    files: tuple[Path, ...]
    runs: int
    notes: tuple[str, ...]


def write(what: str, folder: SweepFolder, out: Path | None, scores: Scores) -> Written:
    """Write a sweep in the format of another tool.

    Args:
        what: the format.
        folder: the sweep.
        out: a new or an empty folder; None for the one in the sweep's analysis, whose files are replaced.
        scores: its declared measures.

    Raises:
        InputError: what the format needs is not installed, no run has ended, the folder holds files or cannot be
            written to, or a text holds a secret or a home folder.
        RecordError: a recorded file is damaged.
    """
    writer = _writer(what)
    every = conditions(folder)
    found = [one for one in every if one.runs]
    if not found:
        raise InputError(
            f"No run of '{folder.path}' has ended, so nothing can be exported: foundry resume goes on with it."
        )
    path = out or folder.export_dir(what)
    if out is None:
        shutil.rmtree(path, ignore_errors=True)
    ensure_writable(path)
    if any(path.iterdir()):
        raise InputError(f"'{path}' holds files: name a new or an empty folder for the export.")
    files = writer(found, scores, path)
    return Written(path, files.paths, sum(len(one.runs) for one in found), (*_missing(every), *files.notes))


def _writer(what: str) -> Write:
    try:
        module = importlib.import_module(_WRITERS[what])
    except ModuleNotFoundError as error:
        name = (error.name or "").partition(".")[0]
        raise InputError(f"{name} is not installed: pip install 'foundry-worlds[{what}]'") from error
    writer: Write = module.write
    return writer


def _missing(every: Sequence[ExportedCondition]) -> list[str]:
    left = {one.label: one.asked - len(one.runs) for one in every}
    return [f"{condition}: {runs} runs that have not ended are left out" for condition, runs in left.items() if runs]
