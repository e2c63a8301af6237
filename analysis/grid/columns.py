"""The columns of `steps.parquet` for runs of 2D worlds."""

from __future__ import annotations

import pyarrow as pa  # type: ignore[import-untyped]

from foundry.declared import Declared


def schema(_: Declared) -> pa.Schema:
    """Return the columns: those of the records, and `said` in the place of a message's text."""
    return pa.schema(
        [
            ("step", pa.int32()),
            ("agent", pa.int32()),
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
    )
