"""From the lines of a run of a 2D world to arrays."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import msgspec
import numpy as np

from analysis.costs import RunCost, cost_of
from analysis.lines import STEPS
from analysis.run import CHOICES, OUTCOMES, OUTSIDE, GridRun, GridSettings, IntArray
from foundry.errors import InputError, RecordError
from foundry.records import GridStep, Message
from foundry.storing.store import RunFolder


@dataclass(frozen=True)
class GridRecords:
    """The lines of one run of a 2D world."""

    steps: list[GridStep]
    messages: list[Message]

    def rows(self) -> list[dict[str, Any]]:
        """Return the steps as rows of a table."""
        return [msgspec.structs.asdict(step) for step in self.steps]

    def columns(self, names: Iterable[str]) -> dict[str, list[Any]]:
        """Return the steps by column, many times as fast as by row."""
        return {name: list(map(attrgetter(name), self.steps)) for name in names}

    def arrays(self, folder: RunFolder) -> GridRun:
        """Return a complete run as arrays.

        Raises:
            InputError: the settings of its world are not those of a 2D one.
            RecordError: the steps are not one per agent and step, or do not follow on one another.
        """
        world = settings(folder)
        rows, file = self.steps, folder.path / STEPS
        shape = (len(rows) // world.agents, world.agents)
        expected = [(step + 1, agent) for step in range(shape[0]) for agent in range(shape[1])]
        if not rows or [(row.step, row.agent) for row in rows] != expected:
            raise RecordError(f"{file} does not hold one line per step and agent, in this order.")
        try:
            return _grid_run(folder.id, world, self, shape, cost=cost_of(folder.summary()))
        except (KeyError, ValueError, OverflowError) as error:
            raise RecordError(f"{file} does not fit the run's world: {error}") from error


def is_grid(config: dict[str, Any]) -> bool:
    """Return whether the configured world is a 2D one, by the setting that only those have."""
    return "half_size" in config["world"]


def settings(folder: RunFolder) -> GridSettings:
    """Return the settings of the run's world.

    Raises:
        InputError: it is not a 2D world.
    """
    world = folder.config()["world"]
    try:
        return msgspec.convert(world, GridSettings)
    except msgspec.ValidationError as error:
        raise InputError(
            f"World '{world.get('name', '?')}' of run {folder.id} cannot be analysed: it is not a 2D world ({error})."
        ) from error


def _grid_run(
    run: str, world: GridSettings, records: GridRecords, shape: tuple[int, int], *, cost: RunCost | None
) -> GridRun:
    rows = records.steps

    def column(values: Iterable[Any], dtype: Any = np.int64) -> Any:
        return np.fromiter(values, dtype=dtype, count=len(rows)).reshape(shape)

    x = _states(column(row.x for row in rows), column(row.x_next for row in rows))
    y = _states(column(row.y for row in rows), column(row.y_next for row in rows))
    places: dict[str | None, int] = {place.name: index for index, place in enumerate(world.places)}
    places[None] = OUTSIDE
    place = np.vstack([column(places[row.place] for row in rows), world.areas(x[-1:], y[-1:])])
    if not np.array_equal(place, world.areas(x, y)):
        raise ValueError("an agent's place is not the one its position is in")
    choices = {name: index for index, name in enumerate(CHOICES)}
    outcomes = {outcome: index for index, outcome in enumerate(OUTCOMES)}
    return GridRun(
        id=run,
        world=world,
        x=x,
        y=y,
        place=place,
        choice=column(choices[row.direction or "stay"] for row in rows),
        moved=column((row.moved for row in rows), np.bool_),
        outcome=column(outcomes[row.outcome] for row in rows),
        message_outcome=column(outcomes[row.message_outcome] for row in rows),
        fires=_fires(world, rows, shape),
        said=column((row.message for row in rows), np.object_),
        contacts=_triples((row.step, row.agent, other) for row in rows for other in row.neighbours),
        deliveries=_triples((line.step, line.sender, line.recipient) for line in records.messages),
        cost=cost,
    )


def _states(before: IntArray, after: IntArray) -> IntArray:
    """Return the T + 1 states of T steps, (T + 1, N)."""
    if not np.array_equal(before[1:], after[:-1]):
        raise ValueError("a step does not start where the one before it ended")
    return np.vstack([before, after[-1:]])


def _fires(world: GridSettings, rows: Sequence[GridStep], shape: tuple[int, int]) -> Any:
    """Return which fires were perceived, (T, N, F)."""
    index = {fire.name: number for number, fire in enumerate(world.fires)}
    seen = np.zeros((len(rows), len(index)), dtype=np.bool_)
    for number, row in enumerate(rows):
        for name in row.fires:
            seen[number, index[name]] = True
    return seen.reshape(*shape, len(index))


def _triples(rows: Iterable[tuple[int, int, int]]) -> IntArray:
    return np.array(list(rows), dtype=np.int64).reshape(-1, 3)
