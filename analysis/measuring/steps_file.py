"""Writes `steps.parquet`: the steps of all runs, without their texts."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import pyarrow as pa  # type: ignore[import-untyped]
import pyarrow.parquet as pq  # type: ignore[import-untyped]

from analysis.form import Records

_RUN, _SWEEP = ("run", pa.string()), ("sweep", pa.string())

_ROWS_AT_ONCE = 65_536
"""Number of steps per row group of the Parquet file; one row group per run would take several times as long."""

SAID = "said"
"""The column that says whether the agent sent a message; the text is left out."""

NUMBER = "action_number"
"""The column for actions that are numbers; the column `action` contains labels."""


def steps_table(run: str, records: Records, schema: pa.Schema) -> pa.Table:
    """Return the steps of a run as a table, with the column `run` and the columns of its form."""
    columns = records.columns([name for name in schema.names if name not in (SAID, NUMBER)])
    if SAID in schema.names:
        columns[SAID] = [text is not None for text in records.columns(["message"])["message"]]
    if NUMBER in schema.names:
        actions = columns["action"]
        columns["action"] = [action if isinstance(action, str) else None for action in actions]
        columns[NUMBER] = [None if isinstance(action, str) else action for action in actions]
    steps = [pa.array(columns[field.name], type=field.type) for field in schema]
    runs = pa.array([run] * len(columns["step"]), type=_RUN[1])
    return pa.table([runs, *steps], schema=schema.insert(0, pa.field(*_RUN)))


class StepsFile:
    """An open `steps.parquet`, to which runs are added one by one, so that only a few are in memory."""

    def __init__(self, writer: pq.ParquetWriter, schema: pa.Schema) -> None:
        self._writer = writer
        self._schema = schema
        self._waiting: list[pa.Table] = []
        self._rows = 0

    def add(self, sweep: str, steps: pa.Table) -> None:
        """Append the steps of a run; columns that its form lacks stay empty."""
        if not steps.num_rows:
            return
        if "sweep" in self._schema.names:
            steps = steps.add_column(0, _SWEEP[0], pa.array([sweep] * steps.num_rows, type=_SWEEP[1]))
        self._waiting.append(_as_in(steps, self._schema))
        self._rows += steps.num_rows
        if self._rows >= _ROWS_AT_ONCE:
            self.write_waiting()

    def write_waiting(self) -> None:
        """Write the runs that are in memory."""
        if self._waiting:
            empty = self._schema.empty_table()
            self._writer.write_table(pa.concat_tables([empty, *self._waiting], promote_options="permissive"))
        self._waiting, self._rows = [], 0


@contextmanager
def open_steps_file(path: Path, schemas: Sequence[pa.Schema], *, by_sweep: bool) -> Iterator[StepsFile]:
    """Open a new file for runs with the given columns; if `by_sweep`, its first column is `sweep`."""
    schema = joined(schemas).insert(0, pa.field(*_RUN))
    if by_sweep:
        schema = schema.insert(0, pa.field(*_SWEEP))
    with pq.ParquetWriter(path, schema, compression="zstd") as writer:
        file = StepsFile(writer, schema)
        yield file
        file.write_waiting()


def joined(schemas: Sequence[pa.Schema]) -> pa.Schema:
    """Return the columns of several forms together; a column whose types do not agree becomes text."""
    fields: dict[str, pa.Field] = {}
    for field in (field for schema in schemas for field in schema):
        fields[field.name] = _both(fields[field.name], field) if field.name in fields else field
    return pa.schema(list(fields.values()))


def _both(first: pa.Field, other: pa.Field) -> pa.Field:
    try:
        return pa.unify_schemas([pa.schema([first]), pa.schema([other])], promote_options="permissive").field(0)
    except pa.ArrowTypeError:
        return pa.field(first.name, pa.string())


def _as_in(steps: pa.Table, schema: pa.Schema) -> pa.Table:
    """Convert columns to text if they are text in the file."""
    for index, field in enumerate(steps.schema):
        wanted = schema.field(field.name).type
        if pa.types.is_string(wanted) and field.type != wanted:
            steps = steps.set_column(index, pa.field(field.name, wanted), steps.column(index).cast(wanted))
    return steps
