"""Checks of this machine: versions, drawing, disk."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Iterable, Iterator
from pathlib import Path

from foundry import provenance
from foundry.doctor.finding import Finding, Status
from foundry.errors import InputError
from foundry.worlds.base import Scenario

CALL_BYTES = 1_100
"""Bytes that a call leaves behind: in its log, in the answer cache, in the steps. Measured on 2D runs."""
RUN_BYTES = 40_000
"""Bytes of a run beside its calls: configuration, summary, blocks of the disk that are not full."""
IMAGE_BYTES = 230_000
"""Bytes of a kept first-person image at 512 x 384, PNG."""
FRAME_BYTES = 60_000
"""Bytes of a kept frame."""

_TIGHT = 3
"""Free space below this many times the need is a warning."""


def check_versions() -> Finding:
    """Say what foundry runs on."""
    versions = {**provenance.versions(), "sqlite": sqlite3.sqlite_version}
    commit = provenance.git_commit()
    text = ", ".join(f"{name} {version}" for name, version in versions.items())
    return Finding("versions", "this machine", Status.OK, text + (f", commit {commit[:12]}" if commit else ""))


def check_drawing(scenarios: Iterable[Scenario]) -> Iterator[Finding]:
    """Say whether this machine can draw, and with what, if a world needs it."""
    seen = [scenario.name for scenario in scenarios if scenario.shows_images]
    if not seen:
        return
    # The world's own module decides how it draws; only those that show images bring VTK in.
    from foundry.worlds.camera.eye.glcheck import check_rendering

    try:
        drawer = check_rendering()
    except InputError as error:
        yield Finding("drawing", ", ".join(seen), Status.PROBLEM, str(error), "Install what it names.")
    else:
        yield Finding("drawing", ", ".join(seen), Status.OK, f"by {drawer.name} ({drawer.why})")


def check_disk(folder: Path, *, runs: int, calls: int, images: int, frames: int) -> Finding:
    """Compare the free space with what the sweep will write.

    Args:
        folder: where it is written; the nearest folder that exists is looked at.
        runs: runs of the sweep.
        calls: calls of all runs, at most.
        images: images that are kept.
        frames: frames that are kept.
    """
    need = runs * RUN_BYTES + calls * CALL_BYTES + images * IMAGE_BYTES + frames * FRAME_BYTES
    there = next(path for path in (folder.absolute(), *folder.absolute().parents) if path.exists())
    free = shutil.disk_usage(there).free
    text = f"about {megabytes(need)} needed, {megabytes(free)} free"
    if free < need:
        return Finding("disk", str(folder), Status.PROBLEM, text, "Choose another output.dir.")
    status = Status.WARNING if free < _TIGHT * need else Status.OK
    return Finding("disk", str(folder), status, text, "It may become tight." if status is Status.WARNING else "")


def megabytes(count: int) -> str:
    """Return a number of bytes for people."""
    return f"{count / 1e9:,.1f} GB" if count >= 1e9 else f"{count / 1e6:,.0f} MB"
