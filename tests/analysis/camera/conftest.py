"""Recorded runs of a 3D world without any model or picture: a made-up walker in an empty hall."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from analysis.camera.camera_run import CameraRun
from analysis.load import read_records, read_run
from declared_forms import CAMERA
from foundry import seeding
from foundry.expansion import Condition, expand
from foundry.records import CameraEpisode, CameraStep, Outcome, Pose
from foundry.storing.store import RunFolder, SweepFolder
from made_up_runs import write_records

GOAL = (6.0, 5.0)

EPISODE = CameraEpisode(
    scene="hall", scene_sha256="0" * 64, renderer="none", target="JAXA logo", target_prims=("/World/Logo",),
    target_label="JAXA logo", radius=1.0, start=Pose(0.0, 0.0, 0.0, 0.0, 0.0), shortest_m=10.0,
    shortest_path=[(0.0, 0.0, 0.0), (6.0, 0.0, 0.0), (6.0, 4.0, 0.0)], walkable_cells=900, cell_m=0.1,
)  # fmt: skip

REPLIES = (
    "I see the JAXA logo. Go on.",
    "I do not see the JAXA logo. Turn.",
    "JAXAのロゴが見えます。",
    "Let me look elsewhere.",
    "I know where the JAXA logo is.",
    "Ich sehe das JAXA-Logo.",
    "",
)
CLAIMS = {"I see the JAXA logo. Go on.", "JAXAのロゴが見えます。"}


@dataclass(frozen=True)
class Walked:
    episode: CameraEpisode
    steps: list[CameraStep]


def walk(seed: int, decisions: int, episode: CameraEpisode = EPISODE, *, stop: bool = False) -> Walked:
    """Return a run of random commands; with `stop` the last one stays at the goal."""
    rng = seeding.stream(seed, "walk")
    pose, steps = episode.start, []
    for number in range(1, decisions + 1):
        ended = stop and number == decisions
        steps.append(_step(rng, number, pose, len(steps) + 1, episode, ended=ended))
        pose = steps[-1].pose_next
    return Walked(episode, steps)


def _step(
    rng: np.random.Generator, number: int, pose: Pose, visited: int, episode: CameraEpisode, *, ended: bool
) -> CameraStep:
    outcome = Outcome.CHOSEN if ended else Outcome(str(rng.choice(["chosen", "chosen", "repaired", "unreadable"])))
    command: dict[str, Any] = {"translate": None, "turn": None, "gaze": None, "stay": ended}
    if outcome in ("chosen", "repaired") and not ended:
        kind = int(rng.integers(6))
        if kind in (0, 1, 2):
            command["translate"] = {"bearing": float(rng.choice([0, 90, 180, -90, 30])), "distance": 1.5}
        if kind in (2, 3):
            command["turn"] = float(rng.choice([45.0, -30.0]))
        if kind == 4:
            command["gaze"] = float(rng.choice([20.0, -20.0]))
        command["stay"] = kind == 5
    yaw = (pose.yaw + (command["turn"] or 0)) % 360
    pitch = min(max(pose.pitch + (command["gaze"] or 0), -30.0), 30.0)
    boundary = "gaze limit" if pitch != pose.pitch + (command["gaze"] or 0) else None
    travelled, x, y = 0.0, pose.x, pose.y
    if command["translate"]:
        travelled = float(rng.choice([1.5, 0.4, 1e-9]))
        boundary = None if travelled == 1.5 else "hatch"
        way = math.radians(yaw + command["translate"]["bearing"])
        x, y = x + travelled * math.cos(way), y + travelled * math.sin(way)
    unknown = rng.random() < 0.1
    distance = None if unknown or not episode.target else math.dist((x, y), GOAL)
    pixels = int(rng.choice([0, 0, 5, 19, 20, 400]))
    return CameraStep(
        step=number, agent=0, pose=pose, pose_next=Pose(x, y, 0.0, yaw, pitch), notes=(),
        reply=str(rng.choice(np.array(REPLIES))), command=command, outcome=outcome, boundary=boundary,
        travelled=travelled, image=None, image_sha256="",
        inference_s=0.0, distance_before=math.dist((pose.x, pose.y), GOAL) if episode.target else None,
        distance_to_goal=distance, visited_cells=3 * visited, target_visible_px=pixels,
        visible_px={"JAXA logo": pixels, "exit door": 300, "rack A1": 19} if pixels else {"rack A1": 40},
        line_of_sight=False, success=ended or bool(rng.random() < 0.2),
    )  # fmt: skip


def write(folder: RunFolder, walked: Walked, status: str = "complete") -> None:
    write_records(folder, status, episode=[walked.episode], steps=walked.steps, messages=[])


def condition(model: str, seeds: int) -> Condition:
    parts = {"world": {"name": "hall", "steps": 30}, "model": {"name": model}, "prompt": {"name": "paper3d"}}
    config = {**parts, "sampling_seed": None, "record": {"frames": False}}
    return Condition({"model": model}, config, tuple(range(seeds)), CAMERA)


@dataclass(frozen=True)
class Recorded:
    folder: RunFolder

    @property
    def run(self) -> CameraRun:
        found = read_run(self.folder, read_records(self.folder, self.folder.summary()))
        assert isinstance(found, CameraRun)
        return found


@pytest.fixture
def claims() -> set[str]:
    return CLAIMS


@pytest.fixture
def camera(tmp_path: Path) -> Callable[..., Recorded]:
    """Return a function that writes one run: of a seed, a number of decisions and changed facts of the episode."""

    def make(
        seed: int = 0, decisions: int = 30, *, stop: bool = False, status: str = "complete", **facts: Any
    ) -> Recorded:
        walked = walk(seed, decisions, msgspec.structs.replace(EPISODE, **facts), stop=stop)
        path = tmp_path / f"camera{len(list(tmp_path.iterdir()))}"
        sweep = SweepFolder.create(path, expand([], [condition("walker", 1)]), {}, [])
        write(sweep.runs()[0], walked, status)
        return Recorded(sweep.runs()[0])

    return make


@pytest.fixture
def camera_sweep(tmp_path: Path) -> Callable[..., SweepFolder]:
    """Return a function that writes a sweep of two models; runs of given numbers have given ends."""

    def make(seeds: int = 2, **ends: str) -> SweepFolder:
        conditions = [condition(model, seeds) for model in ("first", "second")]
        sweep = SweepFolder.create(tmp_path / "hall", expand(["asked"], conditions), {}, [])
        for number, run in enumerate(sweep.runs()):
            write(run, walk(number, 20, stop=number % 2 == 0), ends.get(f"run{number}", "complete"))
        return sweep

    return make
