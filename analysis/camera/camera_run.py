"""One recorded run of a 3D world as arrays, from which all signatures of such runs are computed.

One agent makes T decisions. State 0 is the start, which the world draws. State t is the state after decision t.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from analysis.arrays import STAY, BoolArray, Decisions, FloatArray, IntArray, TextArray
from foundry.records import COMMAND_KINDS, CameraEpisode, command_kind

STILL_M = 1e-3
"""Smallest motion, or change of a distance, that counts, metres.

A smaller motion comes from rounding, or from the slack of the physics at an obstacle.
"""

GAZE_LIMIT = "gaze limit"
"""Value of `boundary` if the gaze turned as far up or down as it can; measures do not count this as an obstacle."""


@dataclass(frozen=True)
class CameraRun(Decisions):
    """One complete run of a 3D world.

    Attributes:
        foot: positions by state, metres, (T + 1, 3).
        yaw: headings by state, degrees, (T + 1,).
        pitch: gazes by state, degrees, (T + 1,).
        bearing: requested direction of the translation, degrees from the heading, (T,); NaN without a translation.
        asked: requested length of the translation, metres, (T,); 0 without a translation.
        turn: requested turn of the body, degrees, left positive, (T,); 0 without a turn.
        gaze: requested turn of the gaze, degrees, up positive, (T,).
        stay: whether the reply says to stay, (T,).
        outcome: outcome of the call, index into OUTCOMES, (T,).
        boundary: name of the obstacle or limit that shortened the motion, or None, (T,).
        travelled: length of the path, metres, (T,).
        distance: length of the shortest path to the goal by state, metres, (T + 1,); NaN without a goal.
        visited: number of cells visited so far, with those of this decision, (T,).
        target_px: number of pixels of the target in the image, (T,).
        success: whether the goal is reached (near enough and in view) after the decision, (T,).
        replies: texts of the replies, (T,).
        visible_px: number of pixels of each labelled thing in the image, by label; one mapping per decision.
        facts: the episode's keys that `CameraEpisode` lacks.
        answers: answers to questions, as rows with all recorded keys.
        world: the world's configuration.
        readable_only: whether measures leave out unreadable decisions.
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
        """Length of the whole path, metres."""
        return float(self.travelled.sum())

    @property
    def all_readable(self) -> bool:
        """True if all decisions and answers are readable, so that none has to be left out."""
        return super().all_readable and all(answer["answer"] is not None for answer in self.answers)

    @cached_property
    def collided(self) -> BoolArray:
        """For each decision, whether an obstacle, the bounds or the edge of the floor stopped or deflected it, (T,)."""
        flags = [name is not None and name != GAZE_LIMIT for name in self.boundary.tolist()]
        return np.array(flags, dtype=np.bool_)

    @cached_property
    def walked(self) -> BoolArray:
        """For each decision, whether the foot moved by at least a millimetre, (T,)."""
        return np.asarray(self.travelled >= STILL_M)

    @cached_property
    def immobile(self) -> BoolArray:
        """For each decision, whether neither the place nor a direction changed, (T,)."""
        turned = (self.yaw[1:] != self.yaw[:-1]) | (self.pitch[1:] != self.pitch[:-1])
        return np.asarray(~self.walked & ~turned)


def command_kinds(run: CameraRun) -> IntArray:
    """Return the kind of each command as an index into COMMAND_KINDS, (T,); an unreadable reply counts as STAY."""
    kinds = kinds_of(bearing=run.bearing, asked=run.asked, turn=run.turn, gaze=run.gaze)
    return np.asarray(np.where(run.readable, kinds, STAY))


def kinds_of(*, bearing: FloatArray, asked: FloatArray, turn: FloatArray, gaze: FloatArray) -> IntArray:
    """Return each command's kind as an index into COMMAND_KINDS, (T,); the arguments are as in `CameraRun`."""
    amounts = zip(bearing.tolist(), asked.tolist(), turn.tolist(), gaze.tolist(), strict=True)
    return np.array([COMMAND_KINDS.index(command_kind(*amount)) for amount in amounts], dtype=np.int64)
