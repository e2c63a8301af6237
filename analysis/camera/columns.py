"""The columns of `steps.parquet` for runs of 3D worlds."""

from __future__ import annotations

import pyarrow as pa  # type: ignore[import-untyped]

from foundry.declared import Declared

_POSE = ("x", "y", "z", "yaw", "pitch")


def schema(declared: Declared) -> pa.Schema:
    """Return the columns, those of `analysis.camera.records.flat` without texts; `kind` where there are questions."""
    asked = [("kind", pa.string())] if "kind" in declared.streams.get("steps", {}) else []
    return pa.schema(
        [
            ("step", pa.int32()),
            ("agent", pa.int32()),
            *asked,
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
    )
