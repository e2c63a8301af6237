"""Ways that a seed draws: from somewhere to a thing of the scene, neither too short nor too long."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np
from numpy.random import Generator

from foundry.errors import InputError
from foundry.records import Pose
from foundry.worlds.camera.body.navigation import Field
from foundry.worlds.camera.camera_settings import Positive
from foundry.worlds.camera.surroundings import DRAWS, Surroundings, Target
from foundry.worlds.camera.things import Things
from foundry.worlds.validation import read_settings


class WaySettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Which ways are drawn: their length, metres, and how near to the thing at their end counts as reached."""

    shortest: Positive
    longest: Positive
    radius: Positive


def read_way(values: Mapping[str, Any]) -> WaySettings:
    """Return which ways are drawn.

    Raises:
        InputError: a setting is unknown or out of range.
    """
    way = read_settings(WaySettings, values, "world.way")
    if way.shortest > way.longest:
        raise InputError(f"world.way.shortest={way.shortest:g} is above longest={way.longest:g}: swap them.")
    return way


def draw_way(
    around: Surroundings, things: Things, settings: WaySettings, goals: Generator, starts: Generator
) -> tuple[Target, Pose]:
    """Return what a way leads to, and the first pose.

    Raises:
        InputError: the scene has no way of such a length.
    """
    for _ in range(DRAWS):
        name = things.names[int(goals.integers(len(things.names)))]
        target = things.target(name, settings.radius)
        ways = _of_length(target.ways, settings)
        if np.isfinite(ways.distance).any():
            start = around.draw_start(starts, target, ways)
            length = around.way(start, target).length
            if length is not None and settings.shortest <= length <= settings.longest:
                return target, start
    length_m = f"{settings.shortest:g} to {settings.longest:g} m"
    raise InputError(
        f"Scene '{around.settings.scene.asset}' has no way of {length_m} to any of its {len(things.names)} things: "
        "see world.way and world.start."
    )


def _of_length(ways: Field, settings: WaySettings) -> Field:
    """Return ways without those that are too short or too long."""
    fits = (ways.distance >= settings.shortest) & (ways.distance <= settings.longest)
    return Field(np.where(fits, ways.distance, np.inf), ways.following)
