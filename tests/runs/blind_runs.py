"""Runs of agents of a 2D world that look at nothing, drawn straight into arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from analysis.arrays import STAY, BoolArray, IntArray
from analysis.grid.run import HEADINGS, Fire, GridRun, GridSettings, Place
from analysis.grid.walker import legal_moves
from foundry import seeding

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


@dataclass(frozen=True)
class Blind:
    """A policy that draws all it does, with the same chances wherever it is.

    Attributes:
        stay: chance to stay.
        ways: chances of up, down, left and right for a move, over those that the edge allows.
        speak: chance to say something.
        texts: what is said, each as likely.
        in_sight: whether it speaks with a fire in sight alone; the one thing it may see.
    """

    stay: float = 0.2
    ways: tuple[float, float, float, float] = (0.25, 0.25, 0.25, 0.25)
    speak: float = 0.3
    texts: tuple[str, ...] = ("hello", "fire!", "see you", "there is smoke", "well", "so")
    in_sight: bool = False


def blind_run(policy: Blind, seed: int, world: GridSettings = WORLD) -> GridRun:
    """Return a run in which all agents have this policy; they start in any cell alike."""
    rng = seeding.stream(seed, f"blind {policy}")
    shape = (world.steps, world.agents)
    x, y, choice = _walks(policy, rng, world)
    place, fires = world.areas(x, y), _perceived(x[:-1], y[:-1], world)
    contacts = _contacts(x[:-1], y[:-1], place[:-1], world.communication_distance)
    speaks = rng.random(shape) < policy.speak
    speaks &= fires.any(axis=2) | (not policy.in_sight)
    texts = np.array(policy.texts, dtype=np.object_)[rng.integers(len(policy.texts), size=shape)]
    return GridRun(
        id=f"blind-{seed}",
        world=world,
        x=x,
        y=y,
        place=place,
        choice=choice,
        moved=choice != STAY,
        outcome=np.zeros(shape, dtype=np.int64),
        message_outcome=np.zeros(shape, dtype=np.int64),
        fires=fires,
        said=np.where(speaks, texts, None),
        contacts=contacts,
        deliveries=contacts[speaks[contacts[:, 0] - 1, contacts[:, 1]]],
    )


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
