"""Writes `steps.parquet`: the steps of all runs without their texts, for any tool that reads Parquet."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

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

_ROWS_AT_ONCE = 65_536
"""Steps of one row group: writing one a run takes several times as long."""

_SWEEP = ("sweep", pa.string())


def steps_table(run: str, records: Records) -> pa.Table:
    """Return the steps of one run as a table of its kind's columns."""
    schema = SCHEMAS[type(records)]
    columns = records.columns([name for name in schema.names if name not in ("run", "said")])
    columns["run"] = [run] * len(records.steps)
    if "said" in schema.names:
        columns["said"] = [text is not None for text in records.columns(["message"])["message"]]
    return pa.table([pa.array(columns[field.name], type=field.type) for field in schema], schema=schema)


class StepsFile:
    """An open `steps.parquet`; runs are added one by one, so that only the last few are held at a time."""

    def __init__(self, writer: pq.ParquetWriter, schema: pa.Schema) -> None:
        self._writer = writer
        self._schema = schema
        self._waiting: list[pa.Table] = []
        self._rows = 0

    def add(self, sweep: str, steps: pa.Table) -> None:
        """Append the steps of one run of a sweep; columns that its kind does not have are left empty."""
        if not steps.num_rows:
            return
        if "sweep" in self._schema.names:
            steps = steps.add_column(0, _SWEEP[0], pa.array([sweep] * steps.num_rows, type=_SWEEP[1]))
        self._waiting.append(steps)
        self._rows += steps.num_rows
        if self._rows >= _ROWS_AT_ONCE:
            self.write_waiting()

    def write_waiting(self) -> None:
        """Write the runs that are held."""
        if self._waiting:
            empty = self._schema.empty_table()
            self._writer.write_table(pa.concat_tables([empty, *self._waiting], promote_options="permissive"))
        self._waiting, self._rows = [], 0


@contextmanager
def open_steps_file(path: Path, kinds: Collection[type[Records]], *, by_sweep: bool) -> Iterator[StepsFile]:
    """Write a new file for runs of these kinds; with `by_sweep` its first column is `sweep`."""
    found = [schema for kind, schema in SCHEMAS.items() if kind in kinds]
    schema = pa.unify_schemas(found, promote_options="permissive")
    if by_sweep:
        schema = schema.insert(0, pa.field(*_SWEEP))
    with pq.ParquetWriter(path, schema, compression="zstd") as writer:
        file = StepsFile(writer, schema)
        yield file
        file.write_waiting()
