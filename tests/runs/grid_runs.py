"""Makes runs of a 2D world from the cells that agents were in, without any record."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from analysis.grid.grid_run import HEADINGS, GridRun, GridSettings

Cell = tuple[int, int]


def grid_run(paths: Sequence[Sequence[Cell]], **changes: Any) -> GridRun:
    """Return the run in which each agent went along its path, state by state."""
    cells = np.array(paths, dtype=np.int64).transpose(1, 0, 2).reshape(-1, len(paths), 2)
    x, y = cells[..., 0], cells[..., 1]
    steps, agents = len(cells) - 1, len(paths)
    world = GridSettings(
        name="made",
        half_size=changes.pop("half_size", 10),
        agents=agents,
        steps=steps,
        communication_distance=changes.pop("communication_distance", 2.0),
        places=tuple(changes.pop("places", ())),
        fires=tuple(changes.pop("fires", ())),
    )
    ways = np.diff(cells, axis=0)
    fields: dict[str, Any] = {
        "choice": (ways[:, :, None] == HEADINGS).all(axis=3).argmax(axis=2),
        "outcome": np.zeros((steps, agents), dtype=np.int64),
        "message_outcome": np.zeros((steps, agents), dtype=np.int64),
        "fires": changes.pop("fires_seen", np.zeros((steps, agents, len(world.fires)), dtype=np.bool_)),
        "said": np.full((steps, agents), None, dtype=np.object_),
        "contacts": np.zeros((0, 3), dtype=np.int64),
        "deliveries": np.zeros((0, 3), dtype=np.int64),
    } | changes
    moved = np.any(ways != 0, axis=2)
    return GridRun(id="made", world=world, x=x, y=y, place=world.areas(x, y), moved=moved, **fields)
