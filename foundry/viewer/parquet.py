"""The table of a sweep's runs as Parquet: the rows and columns that a page shows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pyarrow as pa  # type: ignore[import-untyped]
import pyarrow.parquet as pq  # type: ignore[import-untyped]

from foundry.errors import not_found
from foundry.storing.notes import Note, notes_of
from foundry.viewer.catalog import CatalogedSweep, places_in


def parquet_of(sweep: CatalogedSweep, columns: Sequence[str], mask: str) -> bytes:
    """Return some rows and columns as a Parquet file, in the order of the runs.

    Args:
        sweep: the sweep.
        columns: keys of rows, `tags` and `notes`, names of factors and of measures.
        mask: base64 (of addresses) of a bit a run, the first of a byte its highest: whether it is among the rows.

    Raises:
        InputError: there is no such column, or the mask is not one of this sweep.
    """
    places, rows, factors = places_in(mask, len(sweep.folder.sweep.runs)), sweep.rows(0, None), sweep.factors()
    known: dict[str, Sequence[Any]] = {key: [row[key] for row in rows] for key in rows[0] if key != "factors"}
    known |= _noted(sweep, known["run"])
    known |= {name: [row["factors"][at] for row in rows] for at, name in enumerate(factors)}
    measures = sweep.measures()
    for name in columns:
        if name in measures:
            known[name] = sweep.measure(name)
        elif name not in known:
            raise not_found("Column", name, [*known, *measures])
    table = pa.table({name: [known[name][place] for place in places] for name in columns})
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink)
    return bytes(sink.getvalue())


def _noted(sweep: CatalogedSweep, runs: Sequence[str]) -> dict[str, list[str]]:
    """Return what is noted of each run, without who wrote it; texts one below the other."""
    of_run: dict[str, list[Note]] = {run: [] for run in runs}
    for note in notes_of(sweep.folder.path).notes:
        of_run.get(note.run, []).append(note)
    return {
        "tags": [" ".join(dict.fromkeys(tag for note in notes for tag in note.tags)) for notes in of_run.values()],
        "notes": ["\n".join(f"{note.place}: {note.text}" for note in notes if note.text) for notes in of_run.values()],
    }
