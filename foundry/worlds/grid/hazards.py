"""Fires: where they are, when they start and who perceives them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

import msgspec
import numpy as np

from foundry.worlds.grid.space import Cell, Count, IntArray, Name, distances


class Fire(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A fire that can be perceived from its start step on; it has no other effect.

    Attributes:
        name: its own name.
        start: first step at which it is perceived.
        position: its cell.
        intensity: 0 to 1.
        radius: largest Euclidean distance at which it is perceived, cells.
    """

    name: Name
    start: Count
    position: Cell
    # int stays int: prompts show the numbers as they were configured.
    intensity: Annotated[int, msgspec.Meta(ge=0, le=1)] | Annotated[float, msgspec.Meta(ge=0, le=1)]
    radius: Annotated[int, msgspec.Meta(ge=0)] | Annotated[float, msgspec.Meta(ge=0)]


def perceived_fires(fires: Sequence[Fire], step: int, cells: IntArray) -> list[list[dict[str, Any]]]:
    """Return for each agent what it perceives of the fires at `step`, in configuration order; cells (n, 2)."""
    seen: list[list[dict[str, Any]]] = [[] for _ in range(len(cells))]
    for fire in fires:
        if fire.start > step:
            continue
        distance = distances(cells, np.asarray(fire.position))
        for agent in np.flatnonzero(distance <= fire.radius).tolist():
            seen[agent].append(
                {
                    "name": fire.name,
                    "x": fire.position[0],
                    "y": fire.position[1],
                    "intensity": fire.intensity,
                    "radius": fire.radius,
                    "distance": float(distance[agent]),
                }
            )
    return seen
