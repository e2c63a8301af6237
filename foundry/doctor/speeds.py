"""The seconds that a call took when the doctor last measured a model, kept beside the answer cache for plans."""

from __future__ import annotations

import json
from pathlib import Path

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
    write_atomically(file, json.dumps({**speeds(cache), model: per_call_s}, indent=1).encode())


def speeds(cache: str) -> dict[str, float]:
    """Return the seconds a call by model, as far as they were measured; what cannot be read counts as not measured."""
    if is_database(cache):
        return {}
    try:
        measured = json.loads(_file(cache).read_bytes())
    except (OSError, ValueError):
        return {}
    if not isinstance(measured, dict):
        return {}
    return {str(model): float(per_call_s) for model, per_call_s in measured.items()}


def _file(cache: str) -> Path:
    return Path(cache).with_suffix(".speeds.json")
