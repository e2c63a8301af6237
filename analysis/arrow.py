"""Converts frames to Arrow tables and Parquet files, which pandas, polars, R and others can read."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa  # type: ignore[import-untyped]
import pyarrow.parquet as pq  # type: ignore[import-untyped]


def arrow_table(frame: pd.DataFrame) -> pa.Table:
    """Return a frame as an Arrow table, without its index.

    A column with values of several types, such as labels and numbers, becomes text: its texts stay, and all other
    values become JSON.
    """
    objects = [name for name, dtype in frame.dtypes.items() if pd.api.types.is_object_dtype(dtype)]
    mixed = {str(name): _texts(frame[name]) for name in objects if not _has_a_type(frame[name])}
    return pa.Table.from_pandas(frame.assign(**mixed) if mixed else frame, preserve_index=False)


def write_parquet(frame: pd.DataFrame, path: Path) -> None:
    """Write a frame as Parquet."""
    pq.write_table(arrow_table(frame), path)


def _has_a_type(column: pd.Series[Any]) -> bool:
    try:
        pa.Array.from_pandas(column)
    except (pa.ArrowInvalid, pa.ArrowTypeError):
        return False
    return True


def _texts(values: pd.Series[Any]) -> pd.Series[Any]:
    texts = [value if value is None or isinstance(value, str) else _json(value) for value in values]
    return pd.Series(texts, index=values.index, dtype=object)


def _json(value: Any) -> str | None:
    missing = isinstance(value, float) and value != value
    return None if missing else json.dumps(value, default=str, ensure_ascii=False)
