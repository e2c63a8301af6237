"""Writes records where the datastore of Every Eval Ever has them; imported only where `jsonschema` is installed."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema

from foundry.errors import InputError, RecordError
from foundry.exporting.conditions import ExportedCondition
from foundry.exporting.every_eval_ever.record import LIBRARY, left_out, model_id, record
from foundry.exporting.shared import Files, Scores
from foundry.storing.store import write_atomically

LEFT_OUT = "left_out.json"
"""The file that says which measures are in no record, and why."""
_NOT_PORTABLE = re.compile(r'[<>:"\\|?*/\x00-\x1f]')


def write(conditions: Sequence[ExportedCondition], scores: Scores, folder: Path) -> Files:
    """Write a record for each condition that has a result, and which measures are in none.

    Raises:
        InputError: no condition has a result.
    """
    files = [_written(condition, scores, folder) for condition in conditions]
    if not any(files):
        raise InputError(
            "No declared measure with a better end has a value, so there is no record: name some with --family, such "
            "as outcome.readable; a probe has none."
        )
    missing = left_out(scores)
    write_atomically(folder / LEFT_OUT, _json(missing))
    notes = _notes(conditions, files, missing, folder)
    return Files(tuple(file for file in files if file is not None), tuple(notes))


def _written(condition: ExportedCondition, scores: Scores, folder: Path) -> Path | None:
    found = record(condition, scores)
    if not found["evaluation_results"]:
        return None
    check(found)
    developer, _, model = model_id(condition).partition("/")
    places = [_NOT_PORTABLE.sub("_", one) for one in (LIBRARY, developer, model)]
    path = folder.joinpath("data", *places, f"{condition.identity(*condition.recorded)}.json")
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, _json(found))
    return path


def check(found: dict[str, Any]) -> None:
    """Hold a record against the published schema.

    Raises:
        RecordError: it is not as the schema says; names the place.
    """
    error = jsonschema.exceptions.best_match(jsonschema.Draft7Validator(_schema()).iter_errors(found))
    if error is not None:
        raise RecordError(f"A record is not as Every Eval Ever wants it: {error.json_path}: {error.message}")


@cache
def _schema() -> dict[str, Any]:
    content: dict[str, Any] = json.loads((Path(__file__).parent / "eval.schema.json").read_text(encoding="utf-8"))
    return content


def _json(content: Any) -> bytes:
    return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False).encode() + b"\n"


def _notes(
    conditions: Sequence[ExportedCondition], files: Sequence[Path | None], missing: dict[str, str], folder: Path
) -> Iterator[str]:
    for condition, file in zip(conditions, files, strict=True):
        if file is None:
            yield f"{condition.label}: no record, since no declared measure with a better end has a value"
    if missing:
        yield f"{len(missing)} declared measures have no better end and are in no record: {folder / LEFT_OUT}"
