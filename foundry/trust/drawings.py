"""Tells a run that another renderer drew from one that was changed."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import msgspec

from foundry.records import NOT_JSON
from foundry.running.difference import CALLS, Difference
from foundry.storing.store import KEPT, RunFolder, kept_file

_RENDERER = "renderer"
"""The key under which a line says what drew."""


@dataclass(frozen=True)
class Renderers:
    """What drew a run, and what draws now, where that is not the same."""

    then: str
    now: str


def renderers_of(recorded: bytes | None, now: bytes) -> Renderers | None:
    """Return what drew, where two lines differ in that alone."""
    try:
        then, fresh = msgspec.json.decode(recorded or b"null"), msgspec.json.decode(now)
    except NOT_JSON:
        return None
    if not (
        isinstance(then, Mapping) and isinstance(fresh, Mapping) and {**then, _RENDERER: ""} == {**fresh, _RENDERER: ""}
    ):
        return None
    drew, draws = then.get(_RENDERER), fresh.get(_RENDERER)
    return Renderers(drew, draws) if drew != draws and isinstance(drew, str) and isinstance(draws, str) else None


def is_of_pictures(difference: Difference) -> bool:
    """Return whether a difference is one of pictures, those of a question among them."""
    asked = difference.file == CALLS and ".images_sha256[" in difference.field
    return asked or difference.file.split("/")[0] in KEPT


def departed_note(run: RunFolder, drew: Renderers, difference: Difference, drawn: Iterable[bytes]) -> str | None:
    """Return what there is to say of a run whose pictures come out otherwise; None where they show something else.

    Args:
        run: the run.
        drew: what drew it.
        difference: the first one.
        drawn: the pictures that its first questions show now.
    """
    from foundry.worlds.camera.eye.likeness import likeness_of

    said = f"was drawn by {drew.then} ({drew.now} here), whose pixels are others, so it cannot be verified here"
    now = next((one for one in drawn if _sha256(one) == difference.now), None)
    then = _kept(run, difference.recorded)
    if now is None or then is None:
        return f"{said}; no kept picture tells whether it shows the same"
    found = likeness_of(then, now)
    if not found.same:
        return None
    return (
        f"{said}; its first picture shows the same (mean difference {found.mean:.2f} of 255, {found.far:.1%} far off)"
    )


def _kept(run: RunFolder, digest: Any) -> bytes | None:
    """Return the kept picture with this SHA-256."""
    contents = (kept_file(run.path, name) for name in run.pictures())
    return next((one for one in contents if one is not None and _sha256(one) == digest), None)


def _sha256(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
