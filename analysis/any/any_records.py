"""Reads the lines of a run of any form, by the record schema of its world."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias

import msgspec
import pyarrow as pa  # type: ignore[import-untyped]

from analysis.any.any_arrays import COMMON, MOST_AGENTS, any_run
from analysis.any.any_run import AnyRun
from analysis.form import NoDecisionsError
from analysis.lines import MESSAGES, STEPS, read_lines
from analysis.measuring.steps_file import NUMBER, SAID
from foundry.declared import Declared
from foundry.errors import RecordError
from foundry.records import Message, Outcome, RunSummary
from foundry.storing.store import RunFolder

_Whole: TypeAlias = Annotated[int, msgspec.Meta(ge=-(1 << 62), le=1 << 62)]
"""A whole number that fits into 64 bits."""

_TYPES: Mapping[str, Any] = {
    "integer": _Whole,
    "id": _Whole,
    "number": float,
    "text": str,
    "flag": bool,
    "label": str,
}
_COMMON_TYPES: Mapping[str, Any] = {
    "step": Annotated[int, msgspec.Meta(ge=1, lt=1 << 31)],
    "agent": Annotated[int, msgspec.Meta(ge=0, lt=MOST_AGENTS)],
    "kind": str | None,
    "action": str | _Whole | float | None,
    "outcome": Outcome,
    "utility": float | None,
    "message": str | None,
}
_NEEDED = ("step", "agent", "action", "outcome")


@dataclass(frozen=True)
class AnyRecords:
    """The lines of one run of any form.

    Attributes:
        unfit: why the lines cannot be read as decisions, which happens in worlds of version 0.1; empty if they can.
    """

    declared: Declared
    steps: list[dict[str, Any]]
    messages: list[Message]
    unfit: str = ""

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys of the decisions: first the keys that the world declares, then further keys as they first occur."""
        occurring = (key for row in self.steps for key in row)
        return tuple(dict.fromkeys([*self.declared.streams.get("steps", ()), *occurring]))

    def rows(self) -> list[dict[str, Any]]:
        """Return the decisions as rows of a table, all with the same keys."""
        keys = self.keys
        return [{key: row.get(key) for key in keys} for row in self.steps]

    def columns(self, names: Iterable[str]) -> dict[str, list[Any]]:
        """Return the decisions as columns, with None where a line lacks the key."""
        return {name: [row.get(name) for row in self.steps] for name in names}

    def decisions(self) -> dict[str, list[Any]]:
        """Return the columns that the records of every form have."""
        return self.columns(COMMON)

    def arrays(self, folder: RunFolder) -> AnyRun:
        """Return a complete run as arrays.

        Raises:
            NoDecisionsError: the world has no schema, and the lines are not decisions.
            RecordError: the lines do not fit the world's schema.
        """
        if self.unfit:
            raise NoDecisionsError(self.unfit)
        return any_run(folder, self.declared, self.decisions(), self.messages)


def read_records(folder: RunFolder, summary: RunSummary | None) -> AnyRecords:
    """Read the lines of a run, without the incomplete last line of an unfinished run.

    Raises:
        RecordError: a file is damaged, was changed after the run, or has a line that does not fit the schema.
    """
    steps = read_lines(folder, STEPS, folder.steps_bytes(), summary, dict[str, Any])
    unfit = _unfit(folder, steps)
    if unfit and folder.declared.streams:
        raise RecordError(unfit)
    messages = read_lines(folder, MESSAGES, folder.messages_bytes(), summary, Message)
    return AnyRecords(folder.declared, steps, messages, unfit)


def _unfit(folder: RunFolder, steps: list[dict[str, Any]]) -> str:
    """Return why the lines do not fit the world's schema, or "" if they fit."""
    try:
        msgspec.convert(steps, list[_line_type(folder.declared)])  # type: ignore[misc]
    except msgspec.ValidationError as error:
        return f"{folder.path / STEPS} does not fit the schema of its world: {error}"
    return ""


def _line_type(declared: Declared) -> type[msgspec.Struct]:
    """Return the type of a decision's line, with the keys that the world declares and the common keys."""
    own = {key: _type_of(kind) for key, kind in declared.streams.get("steps", {}).items()}
    needed = {*own, *_NEEDED}
    fields: list[Any] = []
    keys: dict[str, str] = {}
    for key, kind in {**own, **_COMMON_TYPES}.items():
        name = f"key{len(fields)}"  # a key need not be a name in Python
        keys[name] = key
        fields.append((name, kind) if key in needed else (name, kind, None))
    return msgspec.defstruct("Line", fields, rename=keys, kw_only=True)


def _type_of(kind: str) -> Any:
    array_type = _TYPES.get(kind.removesuffix("?"))
    if array_type is None:
        return Any
    return array_type | None if kind.endswith("?") else array_type


_COLUMN_TYPES = {
    "integer": pa.int64(),
    "id": pa.int64(),
    "number": pa.float64(),
    "flag": pa.bool_(),
    "label": pa.string(),
}
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
    """Return the columns of a table of decisions: the common keys, then declared numbers, flags and labels."""
    own = {key: _COLUMN_TYPES.get(kind.removesuffix("?")) for key, kind in declared.streams.get("steps", {}).items()}
    further = {key: kind for key, kind in own.items() if kind is not None and key not in _COMMON}
    return pa.schema([*_COMMON.items(), *further.items()])
