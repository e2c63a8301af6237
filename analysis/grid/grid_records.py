"""Converts the lines of a run of a 2D world to arrays."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from operator import attrgetter
from typing import Any

import msgspec
import numpy as np
import pandas as pd
import pyarrow as pa  # type: ignore[import-untyped]

from analysis.arrays import OUTCOMES, BoolArray, IntArray
from analysis.grid.grid_run import CHOICES, FURTHER_ACTIONS, NO_EXIT, OUTSIDE, GridRun, GridSettings
from analysis.labelling import Labelling
from analysis.lines import STEPS, read_lines, read_messages
from foundry.declared import Declared
from foundry.errors import InputError, RecordError
from foundry.records import GridStep, Message, RunSummary
from foundry.storing.store import RunFolder


class FurnishedLine(GridStep, frozen=True, kw_only=True):
    """A line of `steps.jsonl` from a world in which agents come and go; a key that is missing has its default value."""

    left: str | None = None
    lost: str | None = None
    blocked: str | None = None
    energy: int = 0
    energy_next: int = 0
    target: int | None = None
    amount: int = 0
    born: tuple[int, int, int] | None = None
    food: int = 0


NONE = -1
"""Index of the outcome in a step in which an agent was not asked."""

_DELIVERY = attrgetter("step", "sender", "recipient")


@dataclass(frozen=True)
class GridRecords:
    """The lines of one run of a 2D world."""

    steps: list[GridStep]
    messages: list[Message]
    _kept: dict[str, list[Any]] = field(default_factory=dict, repr=False, compare=False)

    def rows(self) -> list[dict[str, Any]]:
        """Return the steps as rows of a table."""
        return [msgspec.structs.asdict(step) for step in self.steps]

    def decisions(self) -> dict[str, list[Any]]:
        """Return the columns that the steps of every form have."""
        columns = self.columns(("step", "agent", "outcome", "message"))
        actions = [row.direction or row.action for row in self.steps]
        return {**columns, "kind": ["action"] * len(actions), "action": actions, "utility": [None] * len(actions)}

    def columns(self, names: Iterable[str]) -> dict[str, list[Any]]:
        """Return some keys of the steps as columns, which are made once; this is many times as fast as `rows`."""
        wanted = tuple(names)
        self._kept.update({name: list(map(attrgetter(name), self.steps)) for name in wanted if name not in self._kept})
        return {name: self._kept[name] for name in wanted}

    def arrays(self, folder: RunFolder) -> GridRun:
        """Return a complete run as arrays.

        Raises:
            InputError: the settings do not describe a 2D world.
            RecordError: an agent has no line or several in a step, or a step does not start where the previous one
                ended.
        """
        world = settings(folder)
        rows, file = self.steps, folder.path / STEPS
        asked = list(zip(*self.columns(("step", "agent")).values(), strict=True))
        agents = max([world.agents, *(agent + 1 for _, agent in asked)])
        every = [(step + 1, agent) for step in range(len(rows) // agents) for agent in range(agents)]
        come_and_go = bool(rows) and isinstance(rows[0], FurnishedLine)
        if not rows or asked != (sorted(set(asked)) if come_and_go else every):
            raise RecordError(f"{file} must hold one line per step and agent, in order.")
        try:
            return _grid_run(folder.id, world, self, (rows[-1].step, agents))
        except (KeyError, ValueError, OverflowError, IndexError) as error:
            raise RecordError(f"{file} does not fit the run's world: {error}") from error


def read_records(folder: RunFolder, summary: RunSummary | None) -> GridRecords:
    """Read the lines of a run, without the incomplete last line of an unfinished run.

    Raises:
        InputError: there are lines, but the settings do not describe a 2D world.
        RecordError: a file is damaged, or was changed after the run.
    """
    if folder.steps_bytes():
        settings(folder)
    kind = FurnishedLine if "lost" in folder.declared.streams.get("steps", ()) else GridStep
    steps = read_lines(folder, STEPS, folder.steps_bytes(), summary, kind)
    return GridRecords(steps, read_messages(folder, summary))


def labelled(run: GridRun, labelling: Labelling) -> GridRun:
    """Return the run with a model's labels of its messages, or unchanged if a rule labels them later."""
    if labelling.by_fires is None:
        return run
    fires = tuple(fire.name for fire in run.world.fires)
    return replace(run, labels=labelling.by_fires.get(fires, {}))


def settings(folder: RunFolder) -> GridSettings:
    """Return the settings of the run's world.

    Raises:
        InputError: it is not a 2D world.
    """
    world = folder.world()
    try:
        return msgspec.convert(world, GridSettings)
    except msgspec.ValidationError as error:
        raise InputError(
            f"Run {folder.id} cannot be analysed, because its world '{world.get('name', '?')}' does not have the "
            f"settings of a 2D world: {error}."
        ) from error


def fixtures(folder: RunFolder) -> dict[str, pd.DataFrame]:
    """Return a table of the fires and one of the places of the run's world; positions are in cells.

    Raises:
        InputError: it is not a 2D world.
    """
    world = settings(folder)
    fires = [(fire.name, *fire.position, fire.start, fire.radius) for fire in world.fires]
    places = [
        (place.name, *place.center, place.low[0], place.high[0], place.low[1], place.high[1], place.capacity)
        for place in world.places
    ]
    return {
        "fires": pd.DataFrame(fires, columns=["name", "x", "y", "start", "radius"]),
        "places": pd.DataFrame(places, columns=["name", "x", "y", "x_min", "x_max", "y_min", "y_max", "capacity"]),
    }


def _grid_run(run: str, world: GridSettings, records: GridRecords, shape: tuple[int, int]) -> GridRun:
    rows, keys = records.steps, records.columns(GridStep.__struct_fields__)
    steps, agents = (np.array(keys[name], dtype=np.int64) for name in ("step", "agent"))

    def column(values: list[Any], dtype: Any = np.int64, nothing: Any = 0) -> Any:
        filled = np.full(shape, nothing, dtype=dtype)
        filled[steps - 1, agents] = np.array(values, dtype=dtype)
        return filled

    there = column([True] * len(rows), np.bool_)
    x, y = (_states(column(keys[name]), column(keys[f"{name}_next"]), there) for name in ("x", "y"))
    places: dict[str | None, int] = {place.name: index for index, place in enumerate(world.places)}
    places[None] = OUTSIDE
    stays = np.vstack([there, there[-1:]])
    areas = np.where(stays, world.areas(x, y), OUTSIDE)
    place = np.vstack([column([places[name] for name in keys["place"]], nothing=OUTSIDE), areas[-1:]])
    if not np.array_equal(place, areas):
        raise ValueError("the position of an agent is not in its recorded place")
    choices = {name: index for index, name in enumerate((*CHOICES, *FURTHER_ACTIONS))}
    asked = [way or action for way, action in zip(keys["direction"], keys["action"], strict=True)]
    outcomes = {outcome: index for index, outcome in enumerate(OUTCOMES)}
    outcome, message_outcome = (
        column([outcomes[key] for key in keys[name]], nothing=NONE) for name in ("outcome", "message_outcome")
    )
    heard = np.array(list(map(len, keys["neighbours"])), dtype=np.int64)
    neighbours = np.array(list(chain.from_iterable(keys["neighbours"])), dtype=np.int64)
    return GridRun(
        id=run,
        world=world,
        x=x,
        y=y,
        place=place,
        choice=column([choices[action] for action in asked]),
        moved=column(keys["moved"], np.bool_, nothing=False),
        outcome=outcome,
        message_outcome=message_outcome,
        fires=_fires(world, rows, shape),
        said=column(keys["message"], np.object_, nothing=None),
        contacts=np.column_stack([np.repeat(steps, heard), np.repeat(agents, heard), neighbours]),
        deliveries=np.array(list(map(_DELIVERY, records.messages)), dtype=np.int64).reshape(-1, 3),
        **_comings_and_goings(world, rows, there, column),
    )


def _comings_and_goings(
    world: GridSettings, rows: Sequence[GridStep], there: BoolArray, column: Callable[..., Any]
) -> dict[str, Any]:
    """Return the fields of `GridRun` that are set only if agents come and go in the world."""
    lines = [row for row in rows if isinstance(row, FurnishedLine)]
    if not lines:
        return {}
    exits: dict[str | None, int] = {exit_zone.name: index for index, exit_zone in enumerate(world.exits)} | {
        None: NO_EXIT
    }
    numbers = {
        "energy": [line.energy for line in lines],
        "energy_next": [line.energy_next for line in lines],
        "amount": [line.amount for line in lines],
        "target": [-1 if line.target is None else line.target for line in lines],
        "born": [int(line.born is not None) for line in lines],
        "food": [line.food for line in lines],
    }
    return {
        "present": there,
        "left": column([exits[line.left] for line in lines], nothing=NO_EXIT),
        "lost": column([line.lost is not None for line in lines], np.bool_, nothing=False),
        "living": {name: column(values) for name, values in numbers.items()} if world.energy is not None else None,
    }


def _states(before: IntArray, after: IntArray, there: BoolArray) -> IntArray:
    """Return the states at the start and after each step, (T + 1, N), from the states before and after each step.

    An agent that has not joined yet has its first state, and an agent that is gone its last. All arguments are (T, N).
    """
    filled = np.vstack([before, after[-1:]])
    filled[1:][there] = after[there]
    both = there[1:] & there[:-1]
    if not np.array_equal(before[1:][both], after[:-1][both]):
        raise ValueError("a step does not start where the one before it ended")
    if there.all():
        return filled
    known = np.vstack([there, there[-1:]])
    known[1:] |= there
    states = np.arange(len(filled))[:, None]
    last = np.maximum.accumulate(np.where(known, states, -1), axis=0)
    return np.take_along_axis(filled, np.where(last < 0, known.argmax(axis=0), last), axis=0)


def _fires(world: GridSettings, rows: Sequence[GridStep], shape: tuple[int, int]) -> Any:
    """Return whether each agent perceived each fire, (T, N, F)."""
    index = {fire.name: number for number, fire in enumerate(world.fires)}
    seen = np.zeros((*shape, len(index)), dtype=np.bool_)
    for row in rows:
        for name in row.fires:
            seen[row.step - 1, row.agent, index[name]] = True
    return seen


def schema(_: Declared) -> pa.Schema:
    """Return the columns of the table of decisions; `said` replaces the text of a message."""
    return pa.schema(
        [
            ("step", pa.int32()),
            ("agent", pa.int32()),
            *((name, pa.int32()) for name in ("x", "y", "x_next", "y_next")),
            ("place", pa.string()),
            ("fires", pa.list_(pa.string())),
            ("neighbours", pa.list_(pa.int32())),
            ("said", pa.bool_()),
            ("action", pa.string()),
            ("direction", pa.string()),
            ("moved", pa.bool_()),
            ("outcome", pa.string()),
            ("message_outcome", pa.string()),
        ]
    )
