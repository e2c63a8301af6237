"""Distances in the 2D world: a fire moves on the line from the agent to it, to the cell that is nearest."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any


def fire_moved(observation: Mapping[str, Any], keys: Sequence[str], value: float) -> Mapping[str, Any] | None:
    """Return the observation with a fire at this distance, in the direction in which it is.

    Its cell is rounded, and the distance that is told is that of the cell. None where there is no such fire, where it
    is in the agent's own cell and so in no direction, where the cell is outside the field or too far to be perceived,
    and where fires are of many cells.
    """
    fires, place = observation.get("fires", ()), int(keys[1])
    if not -len(fires) <= place < len(fires) or observation.get("burning") or observation.get("window"):
        return None
    fire, at = fires[place], (observation["x"], observation["y"])
    away = math.dist(at, (fire["x"], fire["y"]))
    if not away or value < 0:
        return None
    x, y = (round(own + (to - own) * value / away) for own, to in zip(at, (fire["x"], fire["y"]), strict=True))
    told = math.dist(at, (x, y))
    if max(abs(x), abs(y)) > observation["half_size"] or told > fire["radius"]:
        return None
    moved = {**fire, "x": x, "y": y, "distance": told}
    return {**observation, "fires": [moved if one is fire else one for one in fires]}


MOVES = {r"fires\.-?\d+\.distance": fire_moved}
