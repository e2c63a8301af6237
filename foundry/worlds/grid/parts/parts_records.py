"""The records of 2D worlds with parts such as walls and energy; they extend `foundry.records.GridStep`."""

from typing import ClassVar

from foundry.records import Agent, GridStep, Message, Record
from foundry.worlds.grid.grid_settings import GridSettings


class FurnishedStep(GridStep, frozen=True, kw_only=True):
    """An agent's step in a world with parts such as walls (`steps.jsonl`); agents that left or died have no line.

    Attributes:
        exits: names of the exits that the agent knew before the move.
        blocked: obstacle of the move that the agent chose: `edge`, `wall`, `agents` (the cell is full), or `exit` (the
            exit lets no more agents out in this step); null if it could move, or did not want to.
        left: name of the exit by which the agent left in this step, or null.
        lost: cause of the agent's death at the end of the step: the name of a fire or a zone, `energy`, `attack`, or
            null.
    """

    exits: tuple[str, ...]
    blocked: str | None
    left: str | None
    lost: str | None


class LivingStep(FurnishedStep, frozen=True, kw_only=True):
    """A line of `steps.jsonl` in a world with energy: one agent's step.

    Attributes:
        energy: the agent's energy before the step.
        energy_next: the agent's energy after the step; 0 if the agent left or died.
        target: id of the agent that this agent tried to share with or attack, or null.
        amount: energy that the agent gathered, shared or took; 0 if the action had no effect.
        born: id and cell (x, y) of the agent's newborn, or null.
        food: units of food in the agent's cell before the step.
    """

    energy: int
    energy_next: int
    target: int | None
    amount: int
    born: tuple[int, int, int] | None
    food: int


class Birth(Agent, frozen=True, kw_only=True):
    """An agent born during the run (`agents.jsonl`).

    Attributes:
        parent: id of the newborn's parent.
        step: step of the birth; the newborn gets its first question in the next step.
    """

    parent: int
    step: int


class Burning(Record, frozen=True, kw_only=True):
    """A cell that catches fire before the questions of a step (`burning.jsonl`).

    Attributes:
        step: 1-based step from which the cell burns.
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
    """One line of `food.jsonl`: a new amount of food in a cell.

    Attributes:
        step: step after which the cell has this amount; 0 for the start.
        x: column.
        y: row, upwards.
        amount: units of food.
    """

    stream: ClassVar[str] = "food"

    step: int
    x: int
    y: int
    amount: int


class Fixture(Record, frozen=True, kw_only=True):
    """The position of a place or a fire that the seed drew for the run (`fixtures.jsonl`).

    Attributes:
        kind: `places` or `fires`.
        name: name of the place or fire.
        x: column of the centre.
        y: row, upwards.
    """

    stream: ClassVar[str] = "fixtures"

    kind: str
    name: str
    x: int
    y: int


def fixtures_of(settings: GridSettings) -> list[Fixture]:
    """Return a record per place and fire if the seed drew their positions; otherwise no records."""
    if not settings.draw_positions:
        return []
    places = [("places", place.name, place.center) for place in settings.places]
    fires = [("fires", fire.name, fire.position) for fire in settings.fires]
    return [Fixture(kind=kind, name=name, x=x, y=y) for kind, name, (x, y) in (*places, *fires)]


def records_of(settings: GridSettings) -> tuple[type[Record], ...]:
    """Return the classes of the records that a world with these settings writes."""
    record_types: list[type[Record]] = [FurnishedStep if settings.energy is None else LivingStep, Message, Agent]
    record_types += [Burning] if settings.fires else []
    record_types += [Growing] if settings.food else []
    record_types += [Birth] if settings.reproduction else []
    return tuple(record_types)
