"""The settings of a 2D world and their checks."""

import math
from collections.abc import Mapping
from typing import Any

import msgspec
import numpy as np

from foundry import seeding
from foundry.errors import InputError
from foundry.seeding.positions import PositionLaw
from foundry.worlds.grid.layouts import Layout, Uniform
from foundry.worlds.grid.parts.parts_settings import (
    FURTHER_ACTIONS,
    Attack,
    Barred,
    Corners,
    Energy,
    Exit,
    Food,
    Leaders,
    Order,
    Reproduction,
    Shape,
    Zone,
)
from foundry.worlds.grid.parts.terrain import Ground, cells_of
from foundry.worlds.grid.space import Cell, Count, Field, Fire, Name, Place, Size
from foundry.worlds.personas import check_attributes
from foundry.worlds.validation import as_list, read_settings, refuse_repeated_names

MOST_AGENTS = 20_000
"""Maximum number of agents; with more agents, no server could answer in a reasonable time."""


class History(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How much an agent remembers.

    Attributes:
        memory: number of the latest own memories that an agent observes; 0 for none.
        messages: number of the latest messages from others; 0 for none.
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
        fires: the fires.
        personas: weight of each value by attribute; the values are drawn independently for each agent.
        layout: the rule that places the agents at the start.
        communication_distance: largest Euclidean distance at which agents can talk, cells.
        history: how much an agent remembers.
        draw_positions: whether the seed draws the positions of places and fires; the settings then give no positions.
        tell_fires: whether agents perceive fires; if not, fires still spread and kill.

    Further parts, all optional:
        walls: rectangles of cells that nobody can enter, by two opposite corners.
        walls_block: `sight`, `talk` or both, which walls block in addition to moves.
        exits: ways out of the world.
        cell_capacity: number of agents that fit in a cell; null for any number.
        view: number of columns and rows that an agent sees to each side; null for the whole grid.
        communication_shape: `circle` for a Euclidean communication distance, `square` for one in columns and rows.
        leaders: the agents that know all exits.
        zones: areas where agents may die.
        order: an instruction to all agents.
        energy: energy of agents; an agent without energy dies.
        food: sources of energy.
        sharing: whether agents can share their energy.
        attack: effect of an attack; null if agents cannot attack.
        reproduction: conditions of a birth; null without births.
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
    draw_positions: bool = False
    tell_fires: bool = True
    walls: tuple[Corners, ...] = ()
    walls_block: tuple[Barred, ...] = ("sight", "talk")
    exits: tuple[Exit, ...] = ()
    cell_capacity: Count | None = None
    view: Count | None = None
    communication_shape: Shape = "circle"
    leaders: Leaders | None = None
    zones: tuple[Zone, ...] = ()
    order: Order | None = None
    energy: Energy | None = None
    food: Food | None = None
    sharing: bool = False
    attack: Attack | None = None
    reproduction: Reproduction | None = None

    def for_seed(self, seed: int) -> "GridSettings":
        """Return the settings of the run with this seed, with the positions that the seed draws, if it draws any."""
        if not self.draw_positions:
            return self
        extents = np.array([place.extent for place in self.places], dtype=np.int64).reshape(-1, 2)
        law = PositionLaw(self.half_size, extents, len(self.fires))
        return law.draw(seeding.stream(seed, "positions")).of(self)

    @property
    def furnished(self) -> bool:
        """True if the world has parts such as walls, exits or energy."""
        further = any(getattr(self, name) for name in _FURTHER) or self.communication_shape != "circle"
        return further or any(fire.spread or fire.risk for fire in self.fires)

    @property
    def most_agents(self) -> int:
        """Largest possible number of agents."""
        return self.agents if self.reproduction is None else max(self.agents, self.reproduction.most)

    @property
    def further_actions(self) -> tuple[str, ...]:
        """Actions other than staying and moving."""
        there = (self.food, self.sharing, self.attack, self.reproduction)
        return tuple(name for name, part in zip(FURTHER_ACTIONS, there, strict=True) if part)

    @property
    def ground(self) -> Ground:
        """The walls and exits. Each access makes a new object, so keep it: it caches the cells seen from each cell."""
        return Ground(self.half_size, self.walls, self.exits)

    @property
    def field(self) -> Field:
        """The grid, its places, and the cells where no agent starts: walls, exits, zones, cells without a way out."""
        if not (self.walls or self.exits or self.zones):
            return Field(self.half_size, self.places)
        ground = self.ground
        closed = {*ground.walls, *ground.exits, *(cell for zone in self.zones for cell in cells_of(zone.corners))}
        if self.exits:
            way_out = ground.steps_to(ground.exits)
            half = range(-self.half_size, self.half_size + 1)
            closed |= {(x, y) for x in half for y in half if (x, y) not in way_out}
        return Field(self.half_size, self.places, frozenset(closed))


_FURTHER = tuple(
    name
    for name in GridSettings.__struct_fields__[GridSettings.__struct_fields__.index("walls") :]
    if name not in ("walls_block", "communication_shape")
)


_POSITIONS = {"places": "center", "fires": "position"}
"""Name of the setting with the position of a place or fire; without this setting, the seed draws the position."""


def read_grid_settings(values: Mapping[str, Any]) -> GridSettings:
    """Return the checked settings, or raise a one-line InputError that names the key."""
    plain = dict(values)
    for key in filter(plain.__contains__, _POSITIONS) if plain.get("draw_positions") is True else ():
        position, items = _POSITIONS[key], as_list(plain[key], f"world.{key}")
        plain[key] = [_unplaced(item, position, f"world.{key}[{n}]") for n, item in enumerate(items)]
    settings = read_settings(GridSettings, plain, "world")
    if settings.draw_positions:
        _check_drawn(settings)
        settings = settings.for_seed(0)
    _check(settings)
    return settings


def _unplaced(item: Any, position: str, where: str) -> Any:
    """Return the settings of a place or fire with a placeholder for its position, which the seed draws later.

    Raises:
        InputError: the settings contain a position.
    """
    if not isinstance(item, Mapping):
        return item
    if position in item:
        raise InputError(
            f"{where}.{position} is {item[position]}, but with world.draw_positions=true the seed draws it. Leave it "
            "out, or use world=cafe_library_drawn."
        )
    return {**item, position: (0, 0)}


def _check_drawn(settings: GridSettings) -> None:
    """Reject random positions if these positions affect even agents that ignore places and fires."""
    if settings.furnished:
        raise InputError(
            "world.draw_positions=true works only without further parts (walls, exits, zones, energy, fires that "
            "spread or kill). Remove them, or set world.draw_positions=false."
        )
    if not isinstance(settings.layout, Uniform):
        raise InputError(
            f"world.draw_positions=true needs the layout 'uniform', but world.layout is "
            f"'{type(settings.layout).__name__.lower()}'. Set layout@world.layout=uniform."
        )


def _check(settings: GridSettings) -> None:
    if settings.agents > MOST_AGENTS:
        raise InputError(f"world.agents={settings.agents} is too many. Give at most {MOST_AGENTS:,}.")
    refuse_repeated_names((place.name for place in settings.places), "world.places")
    refuse_repeated_names((fire.name for fire in settings.fires), "world.fires")
    _check_ground(settings)
    settings.field.check()
    for fire in settings.fires:
        if fire.position not in settings.field:
            raise InputError(
                f"Fire '{fire.name}' is at {list(fire.position)}, beyond the grid "
                f"(world.half_size={settings.half_size})."
            )
        if not math.isfinite(fire.radius):
            raise InputError(f"Fire '{fire.name}' needs a finite radius.")
    reach = settings.communication_distance
    if not (math.isfinite(reach) and reach >= 0):
        raise InputError(f"world.communication_distance is {reach}. Give a number of cells, 0 or more.")
    check_attributes(settings.personas)
    _check_living(settings)
    settings.layout.check(settings.field, settings.agents)


def _check_ground(settings: GridSettings) -> None:
    """Reject walls, zones and exits off the grid, and exits that share a cell with a wall or another exit."""
    refuse_repeated_names((exit_zone.name for exit_zone in settings.exits), "world.exits")
    dangers = [*(zone.name for zone in settings.zones), *(fire.name for fire in settings.fires)]
    refuse_repeated_names(dangers, "world.zones and world.fires")
    ends: dict[str, tuple[Cell, ...]] = {f"world.walls[{n}]": wall for n, wall in enumerate(settings.walls)}
    ends |= {f"Zone '{zone.name}'": zone.corners for zone in settings.zones}
    ends |= {f"Exit '{exit_zone.name}'": exit_zone.cells for exit_zone in settings.exits}
    ends |= {} if settings.order is None else {"world.order.target": settings.order.target}
    grid = Field(settings.half_size, ())
    for where, cells in ends.items():
        for cell in cells:
            if cell not in grid:
                raise InputError(f"{where} is at {list(cell)}, beyond the grid (world.half_size={settings.half_size}).")
    taken: dict[Cell, str] = dict.fromkeys(settings.ground.walls, "a wall")
    for exit_zone in settings.exits:
        for cell in exit_zone.cells:
            if cell in taken:
                raise InputError(
                    f"Exit '{exit_zone.name}' and {taken[cell]} share the cell {list(cell)}. Move one of them."
                )
            taken[cell] = f"exit '{exit_zone.name}'"


def _check_living(settings: GridSettings) -> None:
    energy, birth = settings.energy, settings.reproduction
    needing = [name for name in ("food", "sharing", "attack", "reproduction") if getattr(settings, name)]
    if needing and energy is None:
        raise InputError(f"world.{needing[0]} needs energy, but the world has none. Set world.energy.")
    if energy is not None and energy.most is not None and energy.most < energy.start:
        raise InputError(f"world.energy.start={energy.start} is more than world.energy.most={energy.most} allows.")
    if birth is not None and birth.gives > birth.needs:
        raise InputError(
            f"world.reproduction.gives={birth.gives} is more than the energy that a parent needs "
            f"(world.reproduction.needs={birth.needs}). Give at most {birth.needs}."
        )
    if birth is not None and not settings.agents <= birth.most <= MOST_AGENTS:
        raise InputError(
            f"world.reproduction.most={birth.most} must be at least world.agents={settings.agents}, since it counts "
            f"the agents at the start too, and at most {MOST_AGENTS:,}."
        )
    if settings.leaders is not None and settings.leaders.number > settings.agents:
        raise InputError(f"world.leaders.number={settings.leaders.number} is more than world.agents={settings.agents}.")
    if settings.cell_capacity is not None:
        room = settings.cell_capacity * settings.field.room
        if room < settings.agents:
            raise InputError(
                f"Only {room} agents fit on the grid at the start, but world.agents={settings.agents}. Use fewer "
                "agents or a higher world.cell_capacity."
            )
