"""The seconds that a call took when the doctor last measured a model, kept beside the answer cache for plans."""

from __future__ import annotations

from pathlib import Path

import msgspec

from foundry.models.answers.addresses import is_database
from foundry.storing.run_files import write_atomically


def remember_speed(cache: str, model: str, per_call_s: float) -> None:
    """Keep the seconds a call of a model; beside a database nothing is kept.

    Raises:
        OSError: the file cannot be written.
    """
    if is_database(cache):
        return
    file = _file(cache)
    file.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(file, msgspec.json.encode({**speeds(cache), model: per_call_s}))


def speeds(cache: str) -> dict[str, float]:
    """Return the seconds a call by model, as far as they were measured; what cannot be read counts as not measured."""
    if is_database(cache):
        return {}
    try:
        return msgspec.json.decode(_file(cache).read_bytes(), type=dict[str, float])
    except (OSError, msgspec.MsgspecError):
        return {}


def _file(cache: str) -> Path:
    return Path(cache).with_suffix(".speeds.json")
