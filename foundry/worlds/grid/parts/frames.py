"""The content of a picture of a 2D world with parts such as walls, from the world's state or its records."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np

from foundry.worlds.grid.grid_drawing import Furniture, GridFrame, make_frame
from foundry.worlds.grid.grid_settings import GridSettings
from foundry.worlds.grid.parts.living import ROLES, first_bodies
from foundry.worlds.grid.parts.parts_records import FurnishedStep, LivingStep
from foundry.worlds.grid.parts.senses import talking
from foundry.worlds.grid.parts.terrain import FoodSupply, Ground, SpreadingFires, cells_of
from foundry.worlds.grid.space import Cell


def furnished_frame(
    settings: GridSettings,
    ground: Ground,
    personas: Sequence[dict[str, str]],
    step: int,
    *,
    bodies: Mapping[int, Cell],
    burning: Sequence[Cell],
    food: Mapping[Cell, int],
    gone: Mapping[str, int],
) -> GridFrame:
    """Return the frame after `step` steps.

    Args:
        settings: the world.
        ground: the walls and exits of the world.
        personas: persona of each agent, including agents that may be born.
        step: number of completed steps.
        bodies: cell of each present agent, by id.
        burning: the burning cells.
        food: units of food by cell.
        gone: number of agents that left or died, by exit or cause of death.
    """
    ids = tuple(sorted(bodies))
    cells = [bodies[agent] for agent in ids]
    grid = np.array(cells, dtype=np.int64).reshape(-1, 2)
    near = talking(settings, ground, grid, settings.field.areas(grid)) if cells else ()
    frame = make_frame(settings, [personas[agent] for agent in ids], step, cells, near)
    furniture = Furniture(
        ids=ids,
        walls=tuple(sorted(ground.walls)),
        exits=tuple((exit_zone.name, exit_zone.cells) for exit_zone in settings.exits),
        zones=tuple((zone.name, tuple(cells_of(zone.corners))) for zone in settings.zones),
        burning=tuple(burning),
        food=tuple(sorted((cell, amount / settings.food.amount) for cell, amount in food.items()))
        if settings.food is not None else (),
        gone=tuple(sorted(gone.items())),
    )  # fmt: skip
    if not settings.personas and settings.leaders is not None and settings.leaders.announced:
        roles = tuple(personas[agent]["role"] for agent in ids)
        return replace(frame, furniture=furniture, groups=roles, group_names=ROLES)
    return replace(frame, furniture=furniture)


def recorded_frames(
    settings: GridSettings,
    ground: Ground,
    personas: Sequence[dict[str, str]],
    seed: int,
    records: Sequence[FurnishedStep],
) -> Iterator[GridFrame]:
    """Yield the frames of a run, computed from its recorded steps: the initial state, then one frame per step.

    The seed determines how fires spread and food grows; the steps record how much food agents gather.
    """
    spreading_fires = SpreadingFires(settings.fires, ground, seed)
    food_supply = None if settings.food is None else FoodSupply(settings.food, ground, seed)
    bodies = {agent: body.cell for agent, body in first_bodies(settings, ground, seed).items()}
    gone: dict[str, int] = {}

    def frame(step: int) -> GridFrame:
        food = {} if food_supply is None else dict(food_supply.food)
        burning = tuple(spreading_fires.cells)
        return furnished_frame(
            settings, ground, personas, step, bodies=bodies, burning=burning, food=food, gone=dict(gone)
        )

    spreading_fires.go_on(1)
    yield frame(0)
    for step, group in groupby(records, key=lambda record: record.step):
        for record in group:
            _follow(record, bodies, food_supply, gone)
        if food_supply is not None:
            food_supply.grow(step)
        if step < settings.steps and bodies:
            spreading_fires.go_on(step + 1)
        yield frame(step)


def _follow(
    record: FurnishedStep, bodies: dict[int, Cell], food_supply: FoodSupply | None, gone: dict[str, int]
) -> None:
    """Update the positions, the food and the counts of gone agents by an agent's recorded step."""
    bodies[record.agent] = (record.x_next, record.y_next)
    cause = record.left or record.lost
    if cause is not None:
        gone[cause] = gone.get(cause, 0) + 1
        del bodies[record.agent]
    if isinstance(record, LivingStep):
        if record.action == "gather" and food_supply is not None:
            food_supply.take((record.x, record.y), record.amount)
        if record.born is not None:
            child, x, y = record.born
            bodies[child] = (x, y)
