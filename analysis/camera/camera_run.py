"""One recorded run of a 3D world as arrays; what every signature of such runs is computed from.

T decisions of one agent. State 0 is the start, drawn by the world; state t is the one after decision t.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from analysis.arrays import STAY, BoolArray, Decisions, FloatArray, IntArray, TextArray
from analysis.costs import RunCost
from foundry.records import COMMAND_KINDS, CameraEpisode, command_kind

STILL_M = 1e-3
"""Metres below which a way, or a change of a distance, counts as none: rounding, or the slack at an obstacle."""

GAZE_LIMIT = "gaze limit"
"""The boundary that names no obstacle: the gaze cannot be turned any further."""


@dataclass(frozen=True)
class CameraRun(Decisions):
    """One complete run of a 3D world.

    Attributes:
        id: the run's id.
        episode: what holds for all of it.
        foot: positions by state, metres, (T + 1, 3).
        yaw: headings by state, degrees, (T + 1,).
        pitch: gazes by state, degrees, (T + 1,).
        bearing: way of the translation asked for, degrees from the heading, (T,); NaN where none was.
        asked: length of the translation asked for, metres, (T,); 0 where none was.
        turn: turn of the body, degrees, left positive, (T,); 0 where none was asked for.
        gaze: turn of the gaze asked for, degrees, up positive, (T,).
        stay: whether the agent stayed by its own word, (T,).
        outcome: of the call, index into OUTCOMES, (T,).
        boundary: what stopped or clamped the motion, or None, (T,).
        travelled: length of the way covered, metres, (T,).
        distance: geodesic distance to the goal by state, metres, (T + 1,); NaN where there is none.
        visited: cells visited up to and with this decision, (T,).
        target_px: pixels of the target in the image the model saw, (T,).
        success: whether the goal was reached after the decision: near enough and in view, (T,).
        replies: the raw replies, (T,).
        visible_px: pixels of every labelled thing in the image the model saw, by label; T of them.
        cost: what the run took, or None where that is unknown.
        facts: what its world records of the episode beyond the keys of `CameraEpisode`.
        answers: the answers to questions, beside the decisions that move: rows with all keys of the records.
        world: the settings of its world.
        readable_only: whether the decisions that could not be read are left out of all that is counted.
    """

    id: str
    episode: CameraEpisode
    foot: FloatArray
    yaw: FloatArray
    pitch: FloatArray
    bearing: FloatArray
    asked: FloatArray
    turn: FloatArray
    gaze: FloatArray
    stay: BoolArray
    outcome: IntArray
    boundary: TextArray
    travelled: FloatArray
    distance: FloatArray
    visited: IntArray
    target_px: IntArray
    success: BoolArray
    replies: TextArray
    visible_px: tuple[Mapping[str, int], ...]
    cost: RunCost | None = None
    facts: Mapping[str, Any] = field(default_factory=dict)
    answers: tuple[Mapping[str, Any], ...] = ()
    world: Mapping[str, Any] = field(default_factory=dict)
    readable_only: bool = False

    @property
    def decisions(self) -> int:
        """Number of decisions, T."""
        return len(self.outcome)

    @property
    def has_target(self) -> bool:
        """True if the world has a target."""
        return bool(self.episode.target)

    @property
    def path_length(self) -> float:
        """Length of the whole way covered, metres."""
        return float(self.travelled.sum())

    @property
    def all_readable(self) -> bool:
        """Whether every decision could be read, so that leaving out the others changes nothing."""
        return super().all_readable and all(one["answer"] is not None for one in self.answers)

    @cached_property
    def collided(self) -> BoolArray:
        """Whether an obstacle, the bounds or the edge of the floor stopped or turned aside the motion, (T,)."""
        flags = [name is not None and name != GAZE_LIMIT for name in self.boundary.tolist()]
        return np.array(flags, dtype=np.bool_)

    @cached_property
    def walked(self) -> BoolArray:
        """Whether the foot moved, by a millimetre at least, (T,)."""
        return np.asarray(self.travelled >= STILL_M)

    @cached_property
    def immobile(self) -> BoolArray:
        """True if the pose did not change, (T,)."""
        turned = (self.yaw[1:] != self.yaw[:-1]) | (self.pitch[1:] != self.pitch[:-1])
        return np.asarray(~self.walked & ~turned)


def command_kinds(run: CameraRun) -> IntArray:
    """Return the kind of each command, index into COMMAND_KINDS, (T,); what could not be read moves nothing: STAY."""
    found = kinds_of(bearing=run.bearing, asked=run.asked, turn=run.turn, gaze=run.gaze)
    return np.asarray(np.where(run.readable, found, STAY))


def kinds_of(*, bearing: FloatArray, asked: FloatArray, turn: FloatArray, gaze: FloatArray) -> IntArray:
    """Return the kind of each command, index into COMMAND_KINDS, (T,); the arguments are those of `CameraRun`."""
    amounts = zip(bearing.tolist(), asked.tolist(), turn.tolist(), gaze.tolist(), strict=True)
    return np.array([COMMAND_KINDS.index(command_kind(*one)) for one in amounts], dtype=np.int64)
