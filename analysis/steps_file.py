"""Writes `steps.parquet`: the steps of all runs without their texts, for any tool that reads Parquet."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pyarrow as pa  # type: ignore[import-untyped]
import pyarrow.parquet as pq  # type: ignore[import-untyped]

from analysis.camera_records import CameraRecords
from analysis.grid_records import GridRecords
from analysis.load import Records

_COMMON = [("run", pa.string()), ("step", pa.int32()), ("agent", pa.int32())]
_POSE = ("x", "y", "z", "yaw", "pitch")

SCHEMAS = {
    GridRecords: pa.schema(
        [
            *_COMMON,
            *((name, pa.int32()) for name in ("x", "y", "x_next", "y_next")),
            ("place", pa.string()),
            ("fires", pa.list_(pa.string())),
            ("neighbours", pa.list_(pa.int32())),
            ("said", pa.bool_()),
            ("action", pa.string()),
            ("direction", pa.string()),
            ("moved", pa.bool_()),
            ("outcome", pa.string()),
            ("message_outcome", pa.string()),
        ]
    ),
    CameraRecords: pa.schema(
        [
            *_COMMON,
            *((name, pa.float64()) for name in (*_POSE, *(f"{name}_next" for name in _POSE))),
            *((name, pa.float64()) for name in ("move_bearing", "move_distance", "turn", "gaze")),
            ("stay", pa.bool_()),
            ("outcome", pa.string()),
            ("boundary", pa.string()),
            *((name, pa.float64()) for name in ("travelled", "distance_before", "distance_to_goal")),
            ("visited_cells", pa.int64()),
            ("target_visible_px", pa.int64()),
            ("line_of_sight", pa.bool_()),
            ("success", pa.bool_()),
        ]
    ),
}
"""The columns by kind of run: those of the records, and `said` in the place of a message's text."""

_SWEEP = ("sweep", pa.string())


def steps_table(run: str, records: Records) -> pa.Table:
    """Return the steps of one run as a table of its kind's columns."""
    schema, rows = SCHEMAS[type(records)], records.rows()
    extra = [{"run": run, "said": row.get("message") is not None} for row in rows]
    columns: dict[str, list[Any]] = {
        name: [(more if name in more else row)[name] for row, more in zip(rows, extra, strict=True)]
        for name in schema.names
    }
    return pa.table([pa.array(columns[field.name], type=field.type) for field in schema], schema=schema)


class StepsFile:
    """An open `steps.parquet`; runs are added one by one, so that only one is held at a time."""

    def __init__(self, writer: pq.ParquetWriter, schema: pa.Schema) -> None:
        self._writer = writer
        self._schema = schema

    def add(self, sweep: str, steps: pa.Table) -> None:
        """Append the steps of one run of a sweep; columns that its kind does not have are left empty."""
        if not steps.num_rows:
            return
        steps = steps.add_column(0, _SWEEP[0], pa.array([sweep] * steps.num_rows, type=_SWEEP[1]))
        columns = [
            steps[field.name].cast(field.type)
            if field.name in steps.column_names
            else pa.nulls(steps.num_rows, field.type)
            for field in self._schema
        ]
        self._writer.write_table(pa.table(columns, schema=self._schema))


@contextmanager
def open_steps_file(path: Path, kinds: Collection[type[Records]], *, by_sweep: bool) -> Iterator[StepsFile]:
    """Write a new file for runs of these kinds; with `by_sweep` its first column is `sweep`."""
    found = [schema for kind, schema in SCHEMAS.items() if kind in kinds]
    schema = pa.unify_schemas(found, promote_options="permissive")
    if by_sweep:
        schema = schema.insert(0, pa.field(*_SWEEP))
    with pq.ParquetWriter(path, schema, compression="zstd") as writer:
        yield StepsFile(writer, schema)
