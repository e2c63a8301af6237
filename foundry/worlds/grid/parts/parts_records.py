"""The records of 2D worlds with further parts: what stands in their lines beyond `foundry.records.GridStep`."""

from __future__ import annotations

from typing import ClassVar

from foundry.records import Agent, GridStep, Message, Record
from foundry.worlds.grid.grid_settings import GridSettings


class FurnishedStep(GridStep, frozen=True, kw_only=True):
    """One agent's step in a world with further parts (`steps.jsonl`); those who are gone have no line.

    Attributes:
        exits: names of the exits it knew of before the move.
        blocked: what stopped the move that it asked for: `edge`, `wall`, `agents` (the cell is full), `exit` (it lets
            no more out in this step), or null.
        left: name of the exit by which it left in this step, or null.
        lost: what it died of at the end of the step: the name of a fire or a zone, `energy`, `attack`, or null.
    """

    exits: tuple[str, ...]
    blocked: str | None
    left: str | None
    lost: str | None


class LivingStep(FurnishedStep, frozen=True, kw_only=True):
    """One agent's step in a world with energy (`steps.jsonl`).

    Attributes:
        energy: what it had before the step.
        energy_next: what it has after it; 0 for who is lost for want of it.
        target: id of the agent that it asked to share with or attacked, or null.
        amount: energy that it gathered, shared or took; 0 where nothing came of it.
        born: id and cell (x, y) of the agent that it brought into the world, or null.
        food: what there was to gather in its cell before the step.
    """

    energy: int
    energy_next: int
    target: int | None
    amount: int
    born: tuple[int, int, int] | None
    food: int


class Birth(Agent, frozen=True, kw_only=True):
    """An agent that was brought into the world (`agents.jsonl`).

    Attributes:
        parent: id of who brought it.
        step: the step in which that was; it is asked from the next one on.
    """

    parent: int
    step: int


class Burning(Record, frozen=True, kw_only=True):
    """A cell that catches fire (`burning.jsonl`), before the agents are asked in this step.

    Attributes:
        step: 1-based step from which on it burns.
        x: column.
        y: row, upwards.
        fire: name of the fire.
    """

    stream: ClassVar[str] = "burning"

    step: int
    x: int
    y: int
    fire: str


class Growing(Record, frozen=True, kw_only=True):
    """How much food there is in a cell from now on (`food.jsonl`).

    Attributes:
        step: the step after which it holds; 0 for the start.
        x: column.
        y: row, upwards.
        amount: units.
    """

    stream: ClassVar[str] = "food"

    step: int
    x: int
    y: int
    amount: int


class Fixture(Record, frozen=True, kw_only=True):
    """Where a place or a fire stands that was drawn for the run's seed (`fixtures.jsonl`).

    Attributes:
        kind: `places` or `fires`.
        name: its own name.
        x: column of its centre.
        y: row, upwards.
    """

    stream: ClassVar[str] = "fixtures"

    kind: str
    name: str
    x: int
    y: int


def fixtures_of(settings: GridSettings) -> list[Fixture]:
    """Return where the places and fires of a run stand, where that was drawn."""
    if not settings.draw_positions:
        return []
    places = [("places", place.name, place.center) for place in settings.places]
    fires = [("fires", fire.name, fire.position) for fire in settings.fires]
    return [Fixture(kind=kind, name=name, x=x, y=y) for kind, name, (x, y) in (*places, *fires)]


def records_of(settings: GridSettings) -> tuple[type[Record], ...]:
    """Return the classes of the records that a world with these further parts writes."""
    found: list[type[Record]] = [FurnishedStep if settings.energy is None else LivingStep, Message, Agent]
    found += [Burning] if settings.fires else []
    found += [Growing] if settings.food else []
    found += [Birth] if settings.reproduction else []
    return tuple(found)
