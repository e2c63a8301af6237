"""Recorded sweeps without any model: random walkers that talk, written as a run writes them."""

import shutil
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from declared_forms import GRID
from foundry import seeding
from foundry.expansion import Condition, expand
from foundry.records import GridStep, Message, Outcome
from foundry.storing.store import RunFolder, SweepFolder
from made_up_runs import write_records

OFFSETS = {None: (0, 0), "up": (0, 1), "down": (0, -1), "left": (-1, 0), "right": (1, 0)}

WORLD: dict[str, Any] = {
    "name": "small",
    "half_size": 5,
    "agents": 6,
    "steps": 25,
    "places": [
        {"name": "cafe", "type": "cafe", "center": [-3, 0], "extent": [1, 2], "capacity": 1},
        {"name": "library", "type": "library", "center": [3, 1], "extent": [2, 1], "capacity": 2},
    ],
    "fires": [
        {"name": "fire1", "start": 3, "position": [4, 4], "intensity": 0.8, "radius": 3},
        {"name": "blaze2", "start": 8, "position": [-5, -5], "intensity": 0.5, "radius": 1.5},
    ],
    "communication_distance": 2.5,
    "history": {"memory": 5, "messages": 10},
}

TEXTS = ("hello", "fire1 near me", "火事だ、逃げて", "shall we meet in the cafe?", "there is smoke", "hello")


@dataclass(frozen=True)
class Habits:
    """How a made-up model behaves: probabilities of speaking, of moving, and of an unreadable reply."""

    speak: float = 0.4
    move: float = 0.8
    unreadable: float = 0.1
    texts: Sequence[str] = TEXTS


@dataclass
class Walk:
    steps: list[GridStep] = field(default_factory=list)
    messages: list[Message] = field(default_factory=list)


def place_of(world: dict[str, Any], x: int, y: int) -> str | None:
    for place in world["places"]:
        (cx, cy), (ex, ey) = place["center"], place["extent"]
        if abs(x - cx) <= ex and abs(y - cy) <= ey:
            return str(place["name"])
    return None


def distance(a: Sequence[int], b: Sequence[int]) -> float:
    return float(((a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2) ** 0.5)


def walk(world: dict[str, Any], seed: int, habits: Habits) -> Walk:
    rng = seeding.stream(seed, "walk")
    half, walk = world["half_size"], Walk()
    cells = rng.integers(-half, half, size=(world["agents"], 2), endpoint=True).tolist()
    for step in range(1, world["steps"] + 1):
        rows = [_row(world, habits, rng, step, agent, cells) for agent in range(world["agents"])]
        walk.steps += rows
        walk.messages += [
            Message(step=step, sender=row.agent, recipient=other, text=row.message)
            for row in rows
            if row.message is not None
            for other in row.neighbours
        ]
        cells = [[row.x_next, row.y_next] for row in rows]
    return walk


def _row(
    world: dict[str, Any], habits: Habits, rng: np.random.Generator, step: int, agent: int, cells: list[list[int]]
) -> GridStep:
    x, y = cells[agent]
    here = place_of(world, x, y)
    near = [
        other
        for other in range(len(cells))
        if other != agent
        and distance(cells[other], (x, y)) <= world["communication_distance"]
        and place_of(world, *cells[other]) == here
    ]
    fires = [fire for fire in world["fires"] if fire["start"] <= step]
    message = str(rng.choice(np.array(habits.texts))) if rng.random() < habits.speak else None
    outcome = Outcome(str(rng.choice(["unreadable", "empty", "failed"]))) if rng.random() < habits.unreadable else None
    direction = str(rng.choice(["up", "down", "left", "right"])) if rng.random() < habits.move else None
    direction = None if outcome else direction
    dx, dy = OFFSETS[direction]
    inside = max(abs(x + dx), abs(y + dy)) <= world["half_size"]
    return GridStep(
        step=step,
        agent=agent,
        x=x,
        y=y,
        x_next=x + dx * inside,
        y_next=y + dy * inside,
        place=here,
        fires=tuple(f["name"] for f in fires if distance(f["position"], (x, y)) <= f["radius"]),
        neighbours=tuple(near),
        message=message,
        action="move" if direction else "stay",
        direction=direction,
        moved=direction is not None and inside,
        memory="m",
        reasoning="r",
        message_reasoning="",
        outcome=outcome or Outcome(str(rng.choice(["chosen", "repaired"]))),
        message_outcome=Outcome.CHOSEN if rng.random() < 0.9 else Outcome.TRUNCATED,
    )


def write_run(folder: RunFolder, records: Walk, status: str = "complete") -> None:
    write_records(folder, status, steps=records.steps, messages=records.messages)


def make_condition(model: str, seeds: Sequence[int], factors: Sequence[str] = ("model",), **parts: Any) -> Condition:
    config = {
        "world": parts.get("world", WORLD),
        "model": {"name": model, **parts.get("model_settings", {})},
        "prompt": {"name": parts.get("prompt", "paper"), **parts.get("prompt_settings", {})},
        "sampling_seed": parts.get("sampling_seed"),
        "record": {"frames": False},
    }
    values = {"model": model, "prompt": config["prompt"]["name"], "sampling_seed": config["sampling_seed"]}
    values |= parts.get("values", {})
    return Condition({key: values[key] for key in factors}, config, tuple(seeds), parts.get("declared", GRID))


def write_sweep(path: Path, conditions: Sequence[Condition], habits: dict[str, Habits] | None = None) -> SweepFolder:
    folder = SweepFolder.create(path, expand(["asked"], conditions), {}, [])
    for run in folder.runs():
        config = run.config()
        model = (habits or {}).get(config["model"]["name"], Habits())
        salt = config["sampling_seed"] or 0
        write_run(run, walk(config["world"], 1000 * salt + config["seed"], model))
    return folder


def rewrite_run(folder: RunFolder, status: str) -> None:
    shutil.rmtree(folder.path)
    write_run(folder, walk(folder.config()["world"], folder.config()["seed"], Habits()), status)
