"""The columns of `steps.parquet` for runs of a form that brings none of its own."""

from __future__ import annotations

import pyarrow as pa  # type: ignore[import-untyped]

from analysis.any.records import AnyRecords
from foundry.declared import Declared

NUMBER = "action_number"
"""The column of actions that are numbers; labels are in `action`."""

_TYPES = {"integer": pa.int64(), "number": pa.float64(), "flag": pa.bool_(), "label": pa.string()}
_COMMON = {
    "run": pa.string(),
    "step": pa.int32(),
    "agent": pa.int32(),
    "kind": pa.string(),
    "action": pa.string(),
    NUMBER: pa.float64(),
    "outcome": pa.string(),
    "utility": pa.float64(),
    "said": pa.bool_(),
}


def schema(declared: Declared) -> pa.Schema:
    """Return the columns: those of all forms, then the declared numbers, flags and labels, never a text."""
    own = {key: _TYPES.get(kind.removesuffix("?")) for key, kind in declared.streams.get("steps", {}).items()}
    further = {key: kind for key, kind in own.items() if kind is not None and key not in _COMMON}
    return pa.schema([*_COMMON.items(), *further.items()])


def steps_table(run: str, records: AnyRecords) -> pa.Table:
    """Return the decisions of one run as a table of these columns."""
    columns = schema(records.declared)
    found = records.columns(columns.names)
    actions = found["action"]
    found["run"] = [run] * len(records.steps)
    found["action"] = [one if isinstance(one, str) else None for one in actions]
    found[NUMBER] = [None if isinstance(one, str) else one for one in actions]
    found["said"] = [text is not None for text in records.columns(["message"])["message"]]
    return pa.table([pa.array(found[field.name], type=field.type) for field in columns], schema=columns)
