"""The settings of a 2D world, checked as a whole."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import msgspec

from foundry.errors import InputError
from foundry.worlds.grid.hazards import Fire
from foundry.worlds.grid.layouts import Layout
from foundry.worlds.grid.space import Count, Field, Name, Place, Size
from foundry.worlds.personas import check_attributes
from foundry.worlds.validation import as_list, read_settings, refuse_repeated_names

MOST_AGENTS = 20_000
"""Agents of a world; who is near whom is asked of all pairs, and no server answers as many."""


class History(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How much an agent keeps, newest last; 0 keeps nothing.

    Attributes:
        memory: number of its own memories.
        messages: number of messages from others.
    """

    memory: Size
    messages: Size


class GridSettings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The settings of a 2D world.

    Attributes:
        name: name of the world.
        half_size: both axes run from -half_size to +half_size.
        agents: number of agents.
        steps: number of steps.
        places: rectangles that do not overlap.
        fires: what can be perceived, and from when on.
        personas: attribute -> value -> weight, drawn independently for each agent.
        layout: where agents start.
        communication_distance: largest Euclidean distance at which agents can talk, cells.
        history: how much an agent keeps.
    """

    name: Name
    half_size: Count
    agents: Count
    steps: Count
    places: tuple[Place, ...]
    fires: tuple[Fire, ...] = ()
    personas: dict[str, dict[str | int, float]] = {}
    layout: Layout
    communication_distance: float
    history: History

    @property
    def field(self) -> Field:
        """The grid and its places."""
        return Field(self.half_size, self.places)


def read_grid_settings(values: Mapping[str, Any]) -> GridSettings:
    """Return the checked settings, or raise InputError with one line that names the key."""
    plain = dict(values)
    for key, kind in (("places", Place), ("fires", Fire)):
        if key in plain:
            items = as_list(plain[key], f"world.{key}")
            plain[key] = [read_settings(kind, item, f"world.{key}[{n}]") for n, item in enumerate(items)]
    if "history" in plain:
        plain["history"] = read_settings(History, plain["history"], "world.history")
    settings = read_settings(GridSettings, plain, "world")
    _check(settings)
    return settings


def _check(settings: GridSettings) -> None:
    if settings.agents > MOST_AGENTS:
        raise InputError(f"world.agents={settings.agents} is too many: give at most {MOST_AGENTS:,}.")
    refuse_repeated_names((place.name for place in settings.places), "world.places")
    refuse_repeated_names((fire.name for fire in settings.fires), "world.fires")
    settings.field.check()
    for fire in settings.fires:
        if fire.position not in settings.field:
            raise InputError(
                f"Fire '{fire.name}' is at {list(fire.position)}, beyond the grid of half_size {settings.half_size}."
            )
        if not math.isfinite(fire.radius):
            raise InputError(f"Fire '{fire.name}' needs a finite radius.")
    reach = settings.communication_distance
    if not (math.isfinite(reach) and reach >= 0):
        raise InputError(f"world.communication_distance is {reach}. Give a number of cells, 0 or more.")
    check_attributes(settings.personas)
    settings.layout.check(settings.field, settings.agents)
