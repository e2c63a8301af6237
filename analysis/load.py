"""Reads recorded runs: as tidy tables for people, as arrays for signatures."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import msgspec
import numpy as np
import pandas as pd

from analysis.run import CHOICES, OUTCOMES, OUTSIDE, GridRun, GridSettings, IntArray
from foundry.errors import InputError, RecordError
from foundry.records import GridStep, Message, RunSummary
from foundry.store import RunFolder, SweepFolder

COMPLETE, FAILED, UNFINISHED, NOT_STARTED = "complete", "failed", "unfinished", "not started"
"""How a run stands; the first two as in `run.json`."""

_STEPS, _MESSAGES = "steps.jsonl", "messages.jsonl"
_Line = TypeVar("_Line", GridStep, Message)


@dataclass(frozen=True)
class Loaded:
    """A sweep as tidy tables.

    Attributes:
        runs: one row a run: run, world, model, prompt, seed, status, then the further swept settings.
        steps: one row per run, step and agent; the keys of `foundry.records.GridStep`.
        messages: one row per run and delivery; the keys of `foundry.records.Message`.
    """

    runs: pd.DataFrame
    steps: pd.DataFrame
    messages: pd.DataFrame


@dataclass(frozen=True)
class Records:
    """The lines of one run."""

    steps: list[GridStep]
    messages: list[Message]


def load(path: Path | str) -> Loaded:
    """Load a sweep's folder; runs that have not ended are there as far as they are.

    Raises:
        InputError: it is not a sweep's folder, or its world is not a 2D one.
        RecordError: a recorded file is damaged.
    """
    folders = SweepFolder.open(Path(path)).runs()
    read = [(folder, read_records(folder, folder.summary())) for folder in folders]
    steps = [_frame(folder.id, records.steps, GridStep) for folder, records in read]
    messages = [_frame(folder.id, records.messages, Message) for folder, records in read]
    runs = pd.DataFrame([{**identity(folder), **further_factors(folder)} for folder in folders])
    return Loaded(runs=runs, steps=_joined(steps), messages=_joined(messages))


def identity(folder: RunFolder) -> dict[str, Any]:
    """Return the columns that say which run it is and how it stands."""
    config = folder.config()
    return {
        "run": folder.id,
        "world": config["world"]["name"],
        "model": config["model"]["name"],
        "prompt": config["prompt"]["name"],
        "seed": config["seed"],
        "status": status(folder, folder.summary()),
    }


def status(folder: RunFolder, summary: RunSummary | None) -> str:
    """Return how the run stands."""
    if summary is not None:
        return summary.status
    return UNFINISHED if folder.path.exists() else NOT_STARTED


def further_factors(folder: RunFolder) -> dict[str, Any]:
    """Return the swept settings that have no column of their own."""
    return {
        key: value for key, value in folder.factors.items() if key not in ("world", "model", "prompt", "seed")
    }


def read_records(folder: RunFolder, summary: RunSummary | None) -> Records:
    """Read the lines of a run; the torn last line of a run that has not ended is left out.

    Raises:
        InputError: its world is not a 2D one.
        RecordError: a file is damaged, or is not the one that the run wrote.
    """
    settings(folder)
    return Records(
        steps=_lines(folder, _STEPS, folder.steps_bytes(), summary, GridStep),
        messages=_lines(folder, _MESSAGES, folder.messages_bytes(), summary, Message),
    )


def _lines(
    folder: RunFolder, name: str, content: bytes, summary: RunSummary | None, kind: type[_Line]
) -> list[_Line]:
    file = folder.path / name
    if summary is None:
        content = content[: content.rfind(b"\n") + 1]
    else:
        _check_digest(file, content, summary)
    try:
        return msgspec.json.Decoder(kind).decode_lines(content)
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise RecordError(f"{file} cannot be read: {error}") from error


def _check_digest(file: Path, content: bytes, summary: RunSummary) -> None:
    expected = summary.records_sha256.get(file.name)
    if expected is None and summary.status != COMPLETE:
        return
    if hashlib.sha256(content).hexdigest() != expected:
        raise RecordError(
            f"{file} is not the file that the run wrote (its SHA-256 differs from run.json): "
            "restore it, or delete the run's folder and run it again."
        )


def is_grid(config: dict[str, Any]) -> bool:
    """Return whether the run's world is a 2D one, by the setting that only those have."""
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


def read_run(folder: RunFolder, records: Records) -> GridRun:
    """Return a complete run as arrays.

    Raises:
        RecordError: the steps are not one per agent and step, or do not follow on one another.
    """
    world = settings(folder)
    rows = records.steps
    shape = (len(rows) // world.agents, world.agents)
    expected = [(step + 1, agent) for step in range(shape[0]) for agent in range(shape[1])]
    if not rows or [(row.step, row.agent) for row in rows] != expected:
        raise RecordError(f"{folder.path / _STEPS} does not hold one line per step and agent, in this order.")
    try:
        return _grid_run(folder.id, world, records, shape)
    except (KeyError, ValueError) as error:
        raise RecordError(f"{folder.path / _STEPS} does not fit the run's world: {error}") from error


def _grid_run(run: str, world: GridSettings, records: Records, shape: tuple[int, int]) -> GridRun:
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


def _frame(
    run: str, lines: Sequence[GridStep] | Sequence[Message], kind: type[msgspec.Struct]
) -> pd.DataFrame:
    columns = {name: [getattr(line, name) for line in lines] for name in kind.__struct_fields__}
    return pd.DataFrame({"run": [run] * len(lines), **columns})


def _joined(frames: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Return the frames below one another; empty ones only lend their columns."""
    full = [frame for frame in frames if len(frame)]
    return pd.concat(full, ignore_index=True) if full else frames[0]
