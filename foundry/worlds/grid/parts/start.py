"""How agents begin: where they stand, what they know, and what they have."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Sequence

from foundry import seeding
from foundry.worlds.grid.parts.ground import Ground
from foundry.worlds.grid.parts.living import Body
from foundry.worlds.grid.settings import GridSettings
from foundry.worlds.grid.space import Cell

ROLES = ("leader", "visitor")


def new_body(settings: GridSettings, cell: Cell, energy: int) -> Body:
    """Return an agent that knows nothing yet."""
    history = settings.history
    return Body(cell, energy, memories=deque(maxlen=history.memory), received=deque(maxlen=history.messages))


def first_bodies(settings: GridSettings, ground: Ground, seed: int) -> dict[int, Body]:
    """Return those who are there at the start, by id: as the layout has them, in cells that are not too full."""
    drawn = settings.layout.draw(seeding.stream(seed, "layout"), settings.field, settings.agents)
    cells = _with_room([(x, y) for x, y in drawn.tolist()], settings, ground)
    start = 0 if settings.energy is None else settings.energy.start
    bodies = {agent: new_body(settings, cell, start) for agent, cell in enumerate(cells)}
    rng, leaders = seeding.stream(seed, "known exits"), 0 if settings.leaders is None else settings.leaders.number
    for one in settings.exits:
        draws = rng.random(settings.agents).tolist()
        for agent, draw in enumerate(draws):
            if agent < leaders or draw < one.known:
                bodies[agent].known.add(one.name)
    return bodies


def with_roles(settings: GridSettings, personas: Sequence[dict[str, str]]) -> list[dict[str, str]]:
    """Return the personas with the role of each agent, where leaders are announced."""
    leaders = settings.leaders
    if leaders is None or not leaders.announced:
        return list(personas)
    roles = (ROLES[agent >= leaders.number] for agent in range(len(personas)))
    return [{**persona, "role": role} for persona, role in zip(personas, roles, strict=True)]


def _with_room(cells: Sequence[Cell], settings: GridSettings, ground: Ground) -> list[Cell]:
    """Return the cells, those of agents for whom there is no room replaced by the nearest that has some."""
    if settings.cell_capacity is None:
        return list(cells)
    held: Counter[Cell] = Counter()
    found = []
    for cell in cells:
        if held[cell] >= settings.cell_capacity:
            away = ground.steps_to([cell])
            cell = min((one for one in away if held[one] < settings.cell_capacity), key=lambda one: (away[one], one))
        held[cell] += 1
        found.append(cell)
    return found
