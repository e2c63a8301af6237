"""The columns of `steps.parquet` for runs of a form that brings none of its own."""

from __future__ import annotations

import pyarrow as pa  # type: ignore[import-untyped]

from analysis.measuring.steps_file import NUMBER, SAID
from foundry.declared import Declared

_TYPES = {"integer": pa.int64(), "id": pa.int64(), "number": pa.float64(), "flag": pa.bool_(), "label": pa.string()}
_COMMON = {
    "step": pa.int32(),
    "agent": pa.int32(),
    "kind": pa.string(),
    "action": pa.string(),
    NUMBER: pa.float64(),
    "outcome": pa.string(),
    "utility": pa.float64(),
    SAID: pa.bool_(),
}


def schema(declared: Declared) -> pa.Schema:
    """Return the columns behind `run`: those of all forms, then the declared numbers, flags, labels, never a text."""
    own = {key: _TYPES.get(kind.removesuffix("?")) for key, kind in declared.streams.get("steps", {}).items()}
    further = {key: kind for key, kind in own.items() if kind is not None and key not in _COMMON}
    return pa.schema([*_COMMON.items(), *further.items()])
