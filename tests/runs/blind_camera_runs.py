"""Runs of an agent on an open plane that draws its commands and its claims without regard to what it sees."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from analysis.camera.run import CameraRun
from foundry import seeding
from foundry.records import COMMAND_KINDS, CameraEpisode, Pose

HALF_M = 5.0
"""Half a side of the plane; the body stops at the edge."""

STEP_M, TURN_DEG, GAZE_DEG = 1.0, 30.0, 15.0
_BEARINGS = {"forward": 0.0, "back": 180.0, "left": 90.0, "right": -90.0}
_TURNS = {"turn left": TURN_DEG, "turn right": -TURN_DEG}
_GAZES = {"look up": GAZE_DEG, "look down": -GAZE_DEG}


@dataclass(frozen=True)
class BlindWalker:
    """A policy that draws each command from the same shares, and claims to see the target with the same chance.

    Attributes:
        shares: weights of the kinds of command, in the order of `COMMAND_KINDS`, (9,).
        claim: chance to claim that the target is in view.
    """

    shares: tuple[int, ...] = (1,) * 9
    claim: float = 0.4


@dataclass
class _Track:
    """What happened, decision by decision."""

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0
    pitch: float = 0.0
    rows: list[tuple[float, ...]] = field(default_factory=list)

    def go(self, kind: str, goal: tuple[float, float]) -> None:
        """Note whether the goal is in view, then carry the command out."""
        aside = (math.degrees(math.atan2(goal[1] - self.y, goal[0] - self.x)) - self.yaw + 180) % 360 - 180
        seen = abs(aside) <= 60 and abs(self.pitch) <= 30
        way = math.radians(self.yaw + _BEARINGS.get(kind, 0.0))
        asked = STEP_M if kind in _BEARINGS else 0.0
        to = [
            max(-HALF_M, min(HALF_M, at + asked * part))
            for at, part in ((self.x, math.cos(way)), (self.y, math.sin(way)))
        ]
        travelled = math.dist((self.x, self.y), to)
        self.x, self.y = to
        turn, gaze = _TURNS.get(kind, 0.0), _GAZES.get(kind, 0.0)
        self.yaw, self.pitch = (self.yaw + turn + 180) % 360 - 180, max(-45.0, min(45.0, self.pitch + gaze))
        bearing = _BEARINGS.get(kind, math.nan)
        self.rows.append((self.x, self.y, self.yaw, self.pitch, bearing, asked, turn, gaze, travelled, seen))


def blind_camera_run(policy: BlindWalker, seed: int, decisions: int) -> CameraRun:
    """Return a run of this policy from the middle of the plane, with a target anywhere."""
    rng = seeding.stream(seed, f"blind {policy}")
    goal = tuple(rng.uniform(-HALF_M, HALF_M, size=2).tolist())
    start = Pose(0.0, 0.0, 0.0, float(rng.integers(12) * TURN_DEG - 180), 0.0)
    kinds = rng.choice(len(COMMAND_KINDS), size=decisions, p=np.array(policy.shares) / sum(policy.shares))
    track = _Track(yaw=start.yaw)
    for kind in kinds.tolist():
        track.go(COMMAND_KINDS[kind], goal)
    rows = np.array(track.rows)
    states = np.vstack([[0.0, 0.0, start.yaw, 0.0], rows[:, :4]])
    claims = rng.random(decisions) < policy.claim
    distance = np.hypot(states[:, 0] - goal[0], states[:, 1] - goal[1])
    pixels = np.where(rows[:, 9] > 0, 100, 0)
    return CameraRun(
        id=f"blind-{seed}",
        episode=_episode(start, goal, float(distance[0])),
        foot=np.column_stack([states[:, :2], np.zeros(len(states))]),
        yaw=states[:, 2],
        pitch=states[:, 3],
        bearing=rows[:, 4],
        asked=rows[:, 5],
        turn=rows[:, 6],
        gaze=rows[:, 7],
        stay=kinds == 0,
        outcome=np.zeros(decisions, dtype=np.int64),
        boundary=np.where(rows[:, 5] > rows[:, 8] + 1e-9, "bounds", None),
        travelled=rows[:, 8],
        distance=distance,
        visited=np.arange(1, decisions + 1),
        target_px=pixels,
        success=np.zeros(decisions, dtype=np.bool_),
        replies=np.where(claims, "I see the logo.", "I do not see the logo.").astype(np.object_),
        visible_px=tuple({"logo": count} for count in pixels.tolist()),
    )


QUESTIONS = {"nearer": 2, "side": 2, "count": 4, "order": 6}
"""How many answers are possible, by the kind of question."""


def blind_answers(skew: float, seed: int, times: int = 30) -> CameraRun:
    """Return a run that answers each kind of question so often, drawing from what is possible.

    Args:
        skew: how often the first of the possible answers is the right one.
        seed: of the draws.
        times: questions of each kind.
    """
    rng = seeding.stream(seed, f"answers {skew}")
    answers = tuple(
        {
            "kind": kind,
            "answer": int(rng.integers(possible)),
            "truth": 0 if rng.random() < skew else int(rng.integers(1, possible)),
            "chance": 1 / possible,
            "scale": None,
        }
        for kind, possible in QUESTIONS.items()
        for _ in range(times)
    )
    walked = blind_camera_run(BlindWalker(), seed, 10)
    return replace(walked, answers=answers, world={"questions": list(QUESTIONS)})


def _episode(start: Pose, goal: tuple[float, ...], shortest: float) -> CameraEpisode:
    return CameraEpisode(
        scene="plane",
        scene_sha256="0" * 64,
        renderer="none",
        target="logo",
        target_prims=("/World/Logo",),
        target_label="logo",
        radius=1.0,
        start=start,
        shortest_path=[(0.0, 0.0, 0.0), (goal[0], goal[1], 0.0)],
        shortest_m=shortest,
        walkable_cells=900,
        cell_m=0.5,
    )
