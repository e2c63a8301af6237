"""Runs of agents that look at nothing, drawn straight into arrays: of a 2D world, on an open plane, of games.

What they do hangs on chances that are known exactly.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.random import Generator

from analysis.any.any_arrays import objects
from analysis.arrays import STAY, BoolArray, FloatArray, IntArray
from analysis.camera.camera_run import CameraRun
from analysis.grid.grid_run import HEADINGS, Fire, GridRun, GridSettings, Place
from analysis.grid.walker import legal_moves
from analysis.rounds.rounds_run import RoundsRun
from blind_any_runs import any_run
from foundry import seeding
from foundry.declared import Actions, Declared
from foundry.records import COMMAND_KINDS, CameraEpisode, Pose

WORLD = GridSettings(
    name="blind",
    half_size=12,
    agents=24,
    steps=60,
    communication_distance=4.0,
    places=(Place("cafe", (-6, 2), (3, 2), 2), Place("library", (7, -5), (2, 2), 3)),
    fires=(Fire("early", 1, (2, 5), 6.0), Fire("edge", 30, (-9, -10), 5.0)),
)
"""Places, fires in the open and at the edge, one that is late enough to have controls."""


@dataclass(frozen=True, kw_only=True)
class Talk:
    speak: float = 0.3
    texts: tuple[str, ...] = ("hello", "fire!", "see you", "there is smoke", "well", "so")
    in_sight: bool = False
    other_texts: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Blind(Talk):
    """A policy that draws all it does, with the same chances wherever it is."""

    stay: float = 0.2
    ways: tuple[float, float, float, float] = (0.25, 0.25, 0.25, 0.25)


def blind_run(policy: Blind, seed: int, world: GridSettings = WORLD) -> GridRun:
    """Return a run in which all agents have this policy; they start in any cell alike."""
    rng = seeding.stream(seed, f"blind {policy}")
    return run_of_walks(f"blind-{seed}", world, _walks(policy, rng, world), policy, rng)


def run_of_walks(
    run: str, world: GridSettings, walks: tuple[IntArray, IntArray, IntArray], talk: Talk, rng: Generator
) -> GridRun:
    x, y, choice = walks
    shape = choice.shape
    place, fires = world.areas(x, y), _perceived(x[:-1], y[:-1], world)
    contacts = _contacts(x[:-1], y[:-1], place[:-1], world.communication_distance)
    speaks = rng.random(shape) < talk.speak
    speaks &= fires.any(axis=2) | (not talk.in_sight)
    texts = np.array(talk.texts, dtype=np.object_)[rng.integers(len(talk.texts), size=shape)]
    if talk.other_texts:
        others = np.array(talk.other_texts, dtype=np.object_)
        texts[:, 1::2] = others[rng.integers(len(others), size=shape)][:, 1::2]
    moved, nothing = (x[1:] != x[:-1]) | (y[1:] != y[:-1]), np.zeros(shape, dtype=np.int64)
    return GridRun(
        id=run, world=world, x=x, y=y, place=place, choice=choice, moved=moved, outcome=nothing,
        message_outcome=nothing, fires=fires & world.tell_fires, said=np.where(speaks, texts, None), contacts=contacts,
        deliveries=contacts[speaks[contacts[:, 0] - 1, contacts[:, 1]]],
    )  # fmt: skip


def _walks(policy: Blind, rng: np.random.Generator, world: GridSettings) -> tuple[IntArray, IntArray, IntArray]:
    """Return columns and rows by state, (T + 1, N), and choices by step, (T, N)."""
    half = world.half_size
    x, y = (np.empty((world.steps + 1, world.agents), dtype=np.int64) for _ in range(2))
    choice = np.empty((world.steps, world.agents), dtype=np.int64)
    x[0], y[0] = rng.integers(-half, half, size=(2, world.agents), endpoint=True)
    moving, draws = rng.random(choice.shape) >= policy.stay, rng.random(choice.shape)
    for step in range(world.steps):
        chances = np.cumsum(legal_moves(x[step], y[step], world) * policy.ways, axis=1)
        way = (draws[step][:, None] * chances[:, -1:] >= chances).sum(axis=1)
        choice[step] = np.where(moving[step], STAY + 1 + way, STAY)
        x[step + 1], y[step + 1] = (x[step], y[step]) + HEADINGS[choice[step]].T
    return x, y, choice


def _perceived(x: IntArray, y: IntArray, world: GridSettings) -> BoolArray:
    burning = np.arange(1, world.steps + 1)[:, None]
    seen = [
        (np.hypot(x - fire.position[0], y - fire.position[1]) <= fire.radius) & (burning >= fire.start)
        for fire in world.fires
    ]
    return np.stack(seen, axis=-1)


def _contacts(x: IntArray, y: IntArray, place: IntArray, distance: float) -> IntArray:
    near = np.hypot(x[:, :, None] - x[:, None], y[:, :, None] - y[:, None]) <= distance
    near &= (place[:, :, None] == place[:, None]) & ~np.eye(x.shape[1], dtype=np.bool_)
    return np.argwhere(near) + (1, 0, 0)


HALF_M = 5.0
"""Half a side of the plane; the body stops at the edge."""

STEP_M, TURN_DEG, GAZE_DEG = 1.0, 30.0, 15.0
_BEARINGS = {"forward": 0.0, "back": 180.0, "left": 90.0, "right": -90.0}
_TURNS = {"turn left": TURN_DEG, "turn right": -TURN_DEG}
_GAZES = {"look up": GAZE_DEG, "look down": -GAZE_DEG}


@dataclass(frozen=True)
class BlindWalker:
    """A policy that draws each command from the same shares, and claims to see the target with the same chance."""

    shares: tuple[int, ...] = (1,) * 9
    claim: float = 0.4


@dataclass
class _Track:
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
        id=f"blind-{seed}", episode=_episode(start, goal, float(distance[0])),
        foot=np.column_stack([states[:, :2], np.zeros(len(states))]), yaw=states[:, 2], pitch=states[:, 3],
        bearing=rows[:, 4], asked=rows[:, 5], turn=rows[:, 6], gaze=rows[:, 7], travelled=rows[:, 8], stay=kinds == 0,
        outcome=np.zeros(decisions, dtype=np.int64), success=np.zeros(decisions, dtype=np.bool_), distance=distance,
        boundary=np.where(rows[:, 5] > rows[:, 8] + 1e-9, "bounds", None), visited=np.arange(1, decisions + 1),
        replies=np.where(claims, "I see the logo.", "I do not see the logo.").astype(np.object_), target_px=pixels,
        visible_px=tuple({"logo": count} for count in pixels.tolist()),
    )  # fmt: skip


QUESTIONS = {"nearer": 2, "side": 2, "count": 4, "order": 6}
"""How many answers are possible, by the kind of question."""


def blind_answers(skew: float, seed: int, times: int = 30) -> CameraRun:
    """Return a run that answers each kind of question so often, drawing from what is possible."""
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
        scene="plane", scene_sha256="0" * 64, renderer="none", target="logo", target_prims=("/World/Logo",),
        target_label="logo", radius=1.0, start=start, shortest_path=[(0.0, 0.0, 0.0), (goal[0], goal[1], 0.0)],
        shortest_m=shortest, walkable_cells=900, cell_m=0.5,
    )  # fmt: skip


AGENTS, ROUNDS, TOKENS = 10, 300, 20
EVENING = Declared(form="rounds", actions={"evening": Actions(labels=("go", "stay"), idle="stay")})
GIVING = Declared(form="rounds", actions={"contribution": Actions(low=0, high=TOKENS, idle=0)})


@dataclass(frozen=True)
class Goers:
    """Agents that go to a bar, each with its own odds between two bounds, and with a chance do what they did last."""

    low: float
    high: float
    habit: float = 0.0

    def play(self, seed: int) -> RoundsRun:
        stream = seeding.stream(seed, "goers")
        goes = _in_habits(
            stream, stream.random((ROUNDS, AGENTS)) < stream.uniform(self.low, self.high, AGENTS), self.habit
        )
        return _game(EVENING, np.where(goes, "go", "stay").tolist(), {"capacity": 0.6})


@dataclass(frozen=True)
class Givers:
    """Agents that give anything from nothing to their own most, and with a chance what they gave last."""

    habit: float = 0.0

    def play(self, seed: int) -> RoundsRun:
        stream = seeding.stream(seed, "givers")
        most = stream.integers(TOKENS + 1, size=AGENTS)
        given = _in_habits(stream, stream.integers(most + 1, size=(ROUNDS, AGENTS)), self.habit)
        run = _game(GIVING, given.tolist(), {"tokens": TOKENS, "multiplier": 2, "reset": True})
        return replace(run, columns={"tokens": objects([TOKENS] * run.decisions)})


GOERS: Mapping[str, Any] = {
    "goes or stays by a coin flip": Goers(0.5, 0.5),
    "goes by its own odds": Goers(0.0, 1.0),
    "goes in habits": Goers(0.3, 0.9, habit=0.5),
}
GIVERS: Mapping[str, Any] = {"gives anything": Givers(), "gives in habits": Givers(habit=0.5)}


def _in_habits(stream: Generator, fresh: Any, habit: float) -> FloatArray:
    """Return decisions (T, N) of which each is with this chance the one before."""
    for step in range(1, len(fresh)):
        fresh[step] = np.where(stream.random(AGENTS) < habit, fresh[step - 1], fresh[step])
    return np.asarray(fresh)


def _game(declared: Declared, actions: Any, world: Mapping[str, Any]) -> RoundsRun:
    (kind,) = declared.actions
    rows = [(step, agent, one) for step, row in enumerate(actions, 1) for agent, one in enumerate(row)]
    return RoundsRun.of(any_run(rows, kind=kind, declared=declared, world=world))
