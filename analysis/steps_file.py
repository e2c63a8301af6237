"""Writes `steps.parquet`: the steps of all runs without their texts, for any tool that reads Parquet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pyarrow as pa  # type: ignore[import-untyped]
import pyarrow.parquet as pq  # type: ignore[import-untyped]

from foundry.records import GridStep

SCHEMA = pa.schema(
    [
        ("run", pa.string()),
        ("step", pa.int32()),
        ("agent", pa.int32()),
        ("x", pa.int32()),
        ("y", pa.int32()),
        ("x_next", pa.int32()),
        ("y_next", pa.int32()),
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
)
"""The columns: those of `foundry.records.GridStep`, and `said` in the place of the message's text."""

_SWEEP = ("sweep", pa.string())


def steps_table(run: str, lines: Sequence[GridStep]) -> pa.Table:
    """Return the steps of one run as a table of this schema."""
    columns: dict[str, list[Any]] = {
        name: [getattr(line, name) for line in lines] for name in SCHEMA.names if name not in ("run", "said")
    }
    columns["run"] = [run] * len(lines)
    columns["said"] = [line.message is not None for line in lines]
    return pa.table([pa.array(columns[field.name], type=field.type) for field in SCHEMA], schema=SCHEMA)


class StepsFile:
    """An open `steps.parquet`; runs are added one by one, so that only one is held at a time."""

    def __init__(self, writer: pq.ParquetWriter, *, by_sweep: bool) -> None:
        self._writer = writer
        self._by_sweep = by_sweep

    def add(self, sweep: str, steps: pa.Table) -> None:
        """Append the steps of one run of a sweep."""
        if self._by_sweep:
            steps = steps.add_column(0, _SWEEP[0], pa.array([sweep] * steps.num_rows, type=_SWEEP[1]))
        if steps.num_rows:
            self._writer.write_table(steps)


@contextmanager
def open_steps_file(path: Path, *, by_sweep: bool) -> Iterator[StepsFile]:
    """Write a new file; with `by_sweep` its first column is `sweep`."""
    schema = pa.schema([_SWEEP, *SCHEMA]) if by_sweep else SCHEMA
    with pq.ParquetWriter(path, schema, compression="zstd") as writer:
        yield StepsFile(writer, by_sweep=by_sweep)
