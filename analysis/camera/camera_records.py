"""Reads the records of a run of a 3D world, and converts them to arrays and tables."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pyarrow as pa  # type: ignore[import-untyped]

from analysis.arrays import OUTCOMES, FloatArray
from analysis.camera.camera_run import CameraRun, kinds_of
from analysis.lines import EPISODE, STEPS, read_further, read_lines, read_messages
from foundry.declared import Declared
from foundry.errors import RecordError
from foundry.records import COMMAND_KINDS, CameraEpisode, CameraStep, Message, Pose, RunSummary
from foundry.storing.store import RunFolder

MOVE = "move"
"""The kind of question whose answer is a movement."""


@dataclass(frozen=True)
class CameraRecords:
    """The records of one run of a 3D world; the episode is None if the run ended before it began.

    Attributes:
        facts: the episode's keys that `CameraEpisode` lacks.
        own: each decision's keys that `CameraStep` lacks; `kind` is `move` for a movement.
    """

    episode: CameraEpisode | None
    steps: list[CameraStep]
    messages: list[Message]
    facts: Mapping[str, Any] = field(default_factory=dict)
    own: Sequence[Mapping[str, Any]] = ()

    def rows(self) -> list[dict[str, Any]]:
        """Return each decision as one row; `flat` names its columns."""
        own = self.own or [{}] * len(self.steps)
        return [{**flat(step), **further} for step, further in zip(self.steps, own, strict=True)]

    def columns(self, names: Iterable[str]) -> dict[str, list[Any]]:
        """Return some columns of the decisions, by name."""
        rows = self.rows()
        return {name: [row[name] for row in rows] for name in names}

    def decisions(self) -> dict[str, list[Any]]:
        """Return the columns that all forms share, by name; `action` is the kind of the command, or else the answer."""
        columns = self.columns(("step", "agent", "outcome", "move_bearing", "move_distance", "turn", "gaze"))
        kinds = kinds_of(
            bearing=_filled(columns.pop("move_bearing"), math.nan),
            asked=_filled(columns.pop("move_distance"), 0.0),
            turn=_filled(columns.pop("turn"), 0.0),
            gaze=_filled(columns.pop("gaze"), 0.0),
        )
        nothing: list[Any] = [None] * len(self.steps)
        asked = self._kinds()
        actions = [
            COMMAND_KINDS[kind] if what == MOVE else step.command.get("answer")
            for kind, what, step in zip(kinds, asked, self.steps, strict=True)
        ]
        return {**columns, "kind": asked, "action": actions, "utility": nothing, "message": nothing}

    def _kinds(self) -> list[str]:
        return [str(own.get("kind", MOVE)) for own in self.own] or [MOVE] * len(self.steps)

    def arrays(self, folder: RunFolder) -> CameraRun:
        """Return the arrays of a complete run's movements; `answers` holds the answers to questions.

        Raises:
            RecordError: a step has several decisions or none, or a decision does not start where the one before ended.
        """
        file = folder.path / STEPS
        if self.episode is None:
            raise RecordError(f"{folder.path / EPISODE} is empty, but every complete run records an episode there.")
        if [(row.step, row.agent) for row in self.steps] != [(step + 1, 0) for step in range(len(self.steps))]:
            raise RecordError(f"{file} must hold one line per decision of its single agent, in order.")
        kinds = self._kinds()
        moves = [row for row, kind in zip(self.steps, kinds, strict=True) if kind == MOVE]
        poses = [self.episode.start, *(row.pose_next for row in moves)]
        if poses[:-1] != [row.pose for row in moves]:
            raise RecordError(f"{file}: a decision does not start at the pose where the decision before ended.")
        answers = tuple(row for row, kind in zip(self.rows(), kinds, strict=True) if kind != MOVE)
        try:
            camera_run = _camera_run(folder.id, self.episode, moves, poses)
            return replace(camera_run, facts=self.facts, answers=answers, world=folder.config()["world"])
        except OverflowError as error:
            raise RecordError(f"{file} holds a number that is too large: {error}") from error


def read_records(folder: RunFolder, summary: RunSummary | None) -> CameraRecords:
    """Return the records of a run, without the incomplete last line of an unfinished run.

    Raises:
        RecordError: a file is damaged, or was changed after the run.
    """
    episodes = read_lines(folder, EPISODE, folder.episode_bytes(), summary, CameraEpisode)
    steps = read_lines(folder, STEPS, folder.steps_bytes(), summary, CameraStep) if episodes else []
    check_commands(folder.path / STEPS, steps)
    facts = read_further(folder, CameraEpisode.stream, summary) if episodes else [{}]
    return CameraRecords(
        episodes[0] if episodes else None,
        steps,
        read_messages(folder, summary),
        facts=_beyond(CameraEpisode, facts[0]),
        own=[_beyond(CameraStep, line) for line in _own_lines(folder, summary)] if episodes else [],
    )


def _own_lines(folder: RunFolder, summary: RunSummary | None) -> list[dict[str, Any]]:
    """Return the decisions with all their keys if the world adds keys of its own; else an empty list."""
    declared = folder.declared.streams.get(CameraStep.stream, {})
    if set(declared) <= set(CameraStep.__struct_fields__):
        return []
    return read_further(folder, CameraStep.stream, summary)


def _beyond(kind: type[msgspec.Struct], line: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys of a recorded line that are no fields of the line's class."""
    return {key: value for key, value in line.items() if key not in kind.__struct_fields__}


class _Translate(msgspec.Struct):
    bearing: float
    distance: float


class _Command(msgspec.Struct):
    translate: _Translate | None
    turn: float | None
    gaze: float | None
    stay: bool


def check_commands(file: Path, steps: Iterable[CameraStep]) -> None:
    """Check that every decision has a valid command; the class `CameraStep` accepts any.

    Raises:
        RecordError: a command is invalid.
    """
    for step in steps:
        try:
            msgspec.convert(step.command, _Command)
        except msgspec.ValidationError as error:
            raise RecordError(
                f"{file} cannot be read, because decision {step.step} has no valid command: {error}"
            ) from error


def flat(step: CameraStep) -> dict[str, Any]:
    """Return a decision as one row of a table, by column.

    The pose becomes x, y, z, yaw and pitch; the pose after the motion has the same names with `_next`. The command
    becomes move_bearing, move_distance, turn, gaze and stay. An answer to a question becomes `answer`.
    """
    row = msgspec.structs.asdict(step)
    before, after, command = row.pop("pose"), row.pop("pose_next"), row.pop("command")
    translate = command["translate"] or {"bearing": None, "distance": None}
    return {
        "step": row.pop("step"),
        "agent": row.pop("agent"),
        **msgspec.structs.asdict(before),
        **{f"{name}_next": value for name, value in msgspec.structs.asdict(after).items()},
        "move_bearing": translate["bearing"],
        "move_distance": translate["distance"],
        **{name: command[name] for name in ("turn", "gaze", "stay", "answer") if name in command},
        **row,
    }


def _camera_run(run: str, episode: CameraEpisode, steps: list[CameraStep], poses: list[Pose]) -> CameraRun:
    rows = [flat(step) for step in steps]

    def column(name: str, dtype: Any) -> Any:
        return np.fromiter((row[name] for row in rows), dtype=dtype, count=len(rows))

    outcomes = {outcome: index for index, outcome in enumerate(OUTCOMES)}
    distances = [row["distance_before"] for row in rows[:1]] + [row["distance_to_goal"] for row in rows]
    return CameraRun(
        id=run,
        episode=episode,
        foot=np.array([(pose.x, pose.y, pose.z) for pose in poses], dtype=np.float64),
        yaw=np.array([pose.yaw for pose in poses], dtype=np.float64),
        pitch=np.array([pose.pitch for pose in poses], dtype=np.float64),
        bearing=_filled((row["move_bearing"] for row in rows), math.nan),
        asked=_filled((row["move_distance"] for row in rows), 0.0),
        turn=_filled((row["turn"] for row in rows), 0.0),
        gaze=_filled((row["gaze"] for row in rows), 0.0),
        stay=column("stay", np.bool_),
        outcome=np.array([outcomes[row["outcome"]] for row in rows], dtype=np.int64),
        boundary=column("boundary", np.object_),
        travelled=column("travelled", np.float64),
        distance=_filled(distances or [None], math.nan),
        visited=column("visited_cells", np.int64),
        target_px=column("target_visible_px", np.int64),
        success=column("success", np.bool_),
        replies=column("reply", np.object_),
        visible_px=tuple(row["visible_px"] for row in rows),
    )


def _filled(values: Iterable[float | None], missing: float) -> FloatArray:
    return np.array([missing if value is None else value for value in values], dtype=np.float64)


_POSE = ("x", "y", "z", "yaw", "pitch")


def schema(declared: Declared) -> pa.Schema:
    """Return the names and types of the columns of `flat`, except columns of texts.

    The column `kind` exists only if the world asks questions.
    """
    asked = [("kind", pa.string())] if "kind" in declared.streams.get("steps", {}) else []
    return pa.schema(
        [
            ("step", pa.int32()),
            ("agent", pa.int32()),
            *asked,
            *((name, pa.float64()) for name in (*_POSE, *(f"{name}_next" for name in _POSE))),
            *((name, pa.float64()) for name in ("move_bearing", "move_distance", "turn", "gaze")),
            ("stay", pa.bool_()),
            ("outcome", pa.string()),
            ("boundary", pa.string()),
            *((name, pa.float64()) for name in ("travelled", "distance_before", "distance_to_goal")),
            ("visited_cells", pa.int64()),
            ("target_visible_px", pa.int64()),
            ("line_of_sight", pa.bool_()),
            ("success", pa.bool_()),
        ]
    )
