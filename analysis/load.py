"""Reads recorded runs: as tidy tables for people, as arrays for signatures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import msgspec
import pandas as pd

from analysis.camera_records import CameraRecords, check_commands
from analysis.camera_run import CameraRun
from analysis.grid_records import GridRecords, is_grid, settings
from analysis.lines import AGENTS, EPISODE, MESSAGES, NOT_STARTED, STEPS, UNFINISHED, read_lines
from analysis.run import GridRun
from foundry.records import Agent, CameraEpisode, CameraStep, GridStep, Message, RunSummary
from foundry.storing.store import RunFolder, SweepFolder

Records: TypeAlias = GridRecords | CameraRecords
"""The lines of one run, by the kind of its world."""

Folders: TypeAlias = Path | str | Sequence[Path | str]
"""The folder of a sweep, or those of several."""

Run: TypeAlias = GridRun | CameraRun
"""One run as arrays."""


@dataclass(frozen=True)
class Loaded:
    """A sweep as tidy tables.

    Attributes:
        runs: one row a run: run, world, model, prompt, seed, status, then the further swept settings.
        steps: one row per run, step and agent; the keys of `foundry.records.GridStep` for runs of 2D worlds, those
            of `CameraStep` for 3D ones, with pose and command spread over columns as in
            `analysis.camera_records.flat`. In a sweep of both, what a kind does not have is missing.
        agents: one row per run and agent with a persona, whose attributes are the columns `persona.<attribute>`.
        messages: one row per run and delivery; the keys of `foundry.records.Message`.
        episodes: one row per run of a 3D world; the keys of `foundry.records.CameraEpisode`.
    """

    runs: pd.DataFrame
    steps: pd.DataFrame
    agents: pd.DataFrame
    messages: pd.DataFrame
    episodes: pd.DataFrame


def folders_of(dirs: Folders) -> list[Path]:
    """Return the folders that are meant: a text is the name of one, not a list of its letters."""
    return [Path(path) for path in ([dirs] if isinstance(dirs, str | Path) else dirs)]


def load(path: Path | str) -> Loaded:
    """Load a sweep's folder; runs that have not ended are there as far as they are.

    Raises:
        InputError: it is not a sweep's folder, or a world is neither a 2D nor a 3D one.
        RecordError: a recorded file is damaged.
    """
    folders = SweepFolder.open(Path(path)).runs()
    read = [(folder.id, read_records(folder, folder.summary())) for folder in folders]
    runs = pd.DataFrame([{**identity(folder), **further_factors(folder)} for folder in folders])
    episodes = [(run, [one.episode]) for run, one in read if isinstance(one, CameraRecords)]
    steps = [_frame(run, records.rows(), GridStep) for run, records in read]
    return Loaded(
        runs=runs,
        steps=_joined(steps),
        agents=_joined([_personas(folder) for folder in folders]),
        messages=_joined([_frame(run, _rows(one.messages), Message) for run, one in read]),
        episodes=_joined([_frame(run, _rows(lines), CameraEpisode) for run, lines in episodes or [("", [])]]),
    )


def _personas(folder: RunFolder) -> pd.DataFrame:
    content, summary = folder.agents_bytes(), folder.summary()
    is_recorded = content or (summary is not None and AGENTS in summary.records_sha256)
    lines = read_lines(folder, AGENTS, content, summary, Agent) if is_recorded else []
    personas = ({f"persona.{name}": value for name, value in line.persona.items()} for line in lines)
    rows = [{"run": folder.id, "agent": line.agent, **persona} for line, persona in zip(lines, personas, strict=True)]
    return pd.DataFrame(rows, columns=None if rows else ["run", "agent"])


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
    return {key: value for key, value in folder.factors.items() if key not in ("world", "model", "prompt", "seed")}


def has_episode(folder: RunFolder, summary: RunSummary | None) -> bool:
    """Return whether the run recorded an episode, as those of 3D worlds do."""
    return bool(folder.episode_bytes()) or (summary is not None and EPISODE in summary.records_sha256)


def is_measurable(folder: RunFolder, summary: RunSummary | None) -> bool:
    """Return whether there are signatures for the run's world."""
    return has_episode(folder, summary) or is_grid(folder.config())


def read_records(folder: RunFolder, summary: RunSummary | None) -> Records:
    """Read the lines of a run; the torn last line of a run that has not ended is left out.

    Raises:
        InputError: there are lines, of a world that is neither a 2D nor a 3D one.
        RecordError: a file is damaged, or is not the one that the run wrote.
    """
    if has_episode(folder, summary):
        episode = read_lines(folder, EPISODE, folder.episode_bytes(), summary, CameraEpisode)
        if episode:
            steps = read_lines(folder, STEPS, folder.steps_bytes(), summary, CameraStep)
            check_commands(folder.path / STEPS, steps)
            return CameraRecords(episode[0], steps, _messages(folder, summary))
    if folder.steps_bytes():
        settings(folder)
    return GridRecords(read_lines(folder, STEPS, folder.steps_bytes(), summary, GridStep), _messages(folder, summary))


def _messages(folder: RunFolder, summary: RunSummary | None) -> list[Message]:
    return read_lines(folder, MESSAGES, folder.messages_bytes(), summary, Message)


def read_run(folder: RunFolder, records: Records) -> Run:
    """Return a complete run as arrays.

    Raises:
        InputError: its world is neither a 2D nor a 3D one.
        RecordError: the steps are not one per agent and step, or do not follow on one another.
    """
    return records.arrays(folder)


def _rows(lines: Sequence[msgspec.Struct]) -> list[dict[str, Any]]:
    return [msgspec.structs.asdict(line) for line in lines]


def _frame(run: str, rows: Sequence[dict[str, Any]], kind: type[msgspec.Struct]) -> pd.DataFrame:
    """Return rows as a table; an empty one has the columns of this kind of record."""
    names = list(rows[0]) if rows else kind.__struct_fields__
    columns = {name: [row[name] for row in rows] for name in names}
    return pd.DataFrame({"run": [run] * len(rows), **columns})


def _joined(frames: Sequence[pd.DataFrame]) -> pd.DataFrame:
    """Return the frames below one another; empty ones only lend their columns."""
    full = [frame for frame in frames if len(frame)]
    return pd.concat(full, ignore_index=True) if full else frames[0]
