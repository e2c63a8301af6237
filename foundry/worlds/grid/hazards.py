"""Fires: where they are, when they start and who perceives them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Annotated, Any

import msgspec
import numpy as np

from foundry.worlds.grid.space import Cell, Count, IntArray, Name, Share, distances


class Fire(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A fire that can be perceived from its start step on; where `spread` and `risk` are 0 it has no other effect.

    Attributes:
        name: its own name.
        start: first step at which it is perceived.
        position: its cell.
        intensity: 0 to 1.
        radius: largest Euclidean distance at which it is perceived, cells; from the nearest of its burning cells.
        spread: chance that a burning cell lights one beside it, each step.
        risk: chance to die of a step that ends in a burning cell.
    """

    name: Name
    start: Count
    position: Cell
    # int stays int: prompts show the numbers as they were configured.
    intensity: Share
    radius: Annotated[int, msgspec.Meta(ge=0)] | Annotated[float, msgspec.Meta(ge=0)]
    spread: Share = 0
    risk: Share = 0


def perceived_fires(
    fires: Sequence[Fire], step: int, cells: IntArray, burning: Mapping[str, IntArray] | None = None
) -> list[list[dict[str, Any]]]:
    """Return for each agent what it perceives of the fires at `step`, in configuration order.

    Args:
        fires: the fires.
        step: 1-based step.
        cells: where the agents stand, (n, 2).
        burning: the burning cells of each fire by its name, (k, 2), where fires spread; None where none does.
    """
    seen: list[list[dict[str, Any]]] = [[] for _ in range(len(cells))]
    for fire in fires:
        spots = np.array([fire.position]) if burning is None else burning[fire.name]
        if fire.start > step or not len(spots):  # where another burns already it finds nothing to light
            continue
        apart = distances(cells[:, None], spots)
        distance, nearest = apart.min(axis=1), apart.argmin(axis=1)
        for agent in np.flatnonzero(distance <= fire.radius).tolist():
            x, y = spots[nearest[agent]].tolist()
            seen[agent].append(_described(fire, (x, y), float(distance[agent])))
    return seen


def fires_perceived_at(cell: Cell, fires: Sequence[Fire], step: int) -> list[dict[str, Any]]:
    """Return what one agent perceives of the fires at `step`, as `perceived_fires` does for many; none spreads."""
    apart = [
        (fire, math.sqrt((cell[0] - fire.position[0]) ** 2 + (cell[1] - fire.position[1]) ** 2))
        for fire in fires
        if fire.start <= step
    ]
    return [_described(fire, fire.position, distance) for fire, distance in apart if distance <= fire.radius]


def _described(fire: Fire, spot: Cell, distance: float) -> dict[str, Any]:
    return {
        "name": fire.name,
        "x": spot[0],
        "y": spot[1],
        "intensity": fire.intensity,
        "radius": fire.radius,
        "distance": distance,
    }
