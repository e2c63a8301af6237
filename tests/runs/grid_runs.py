"""Runs of 2D worlds as arrays: made from the cells that agents were in, or played by a scripted policy."""

import asyncio
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from analysis.grid.grid_run import HEADINGS, GridRun, GridSettings
from analysis.load import read_records, read_run
from episodes import composed, recorded

Cell = tuple[int, int]


def grid_run(paths: Sequence[Sequence[Cell]], **changes: Any) -> GridRun:
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


def whole_run(path: Path, world: str, policy: str, *overrides: str, seed: int) -> GridRun:
    """Play a run of a shipped world to its end and return it; `path` is a folder that does not exist yet."""
    (folder,) = asyncio.run(recorded(path, [composed(world, policy, f"seed={seed}", *overrides)])).runs()
    run = read_run(folder, read_records(folder, None))
    assert isinstance(run, GridRun)
    return run
