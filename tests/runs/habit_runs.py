"""Crowds of agents that ignore fires, places and one another, and keep to ways of their own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import msgspec
import numpy as np

from analysis.arrays import STAY, IntArray
from analysis.grid.run import HEADINGS, GridRun, GridSettings
from analysis.grid.walker import legal_moves
from blind_runs import WORLD, Talk, run_of_walks
from foundry import seeding
from foundry.seeding.positions import PositionLaw

ANEW, BACK, ON = "anew", "back", "on"
"""What an agent does at the edge: draws a way anew, turns back, or asks for the same way on and on."""


@dataclass(frozen=True)
class Habit:
    """How an agent goes.

    Attributes:
        keep: chance to keep the way of the step before; else the way is drawn from `ways`.
        ways: chances of up, down, left and right.
        own: whether the agent has drawn one of the ways for itself, and takes it wherever `keep` fails.
        edge: what it does at the edge.
        stay: chance to stay for a step.
        cycle: choices that follow one another again and again, in place of all that; staying is 0.
    """

    keep: float = 1.0
    ways: tuple[float, float, float, float] = (0.25, 0.25, 0.25, 0.25)
    own: bool = False
    edge: str = ANEW
    stay: float = 0.0
    cycle: tuple[int, ...] = ()


@dataclass(frozen=True)
class Crowd:
    """Agents that take these habits in turn."""

    habits: tuple[Habit, ...]

    def play(self, seed: int, world: GridSettings, arm: str = "told") -> GridRun:
        """Return a run; the arm is another draw of the ways from the same world."""
        settings = placed(world, seed)
        rng = seeding.stream(seed, f"habits {self} {arm}")
        walks = [self._walk(self.habits[agent % len(self.habits)], rng, settings) for agent in range(world.agents)]
        x, y, choice = (np.stack(part, axis=1) for part in zip(*walks, strict=True))
        return run_of_walks(f"habits-{seed}", settings, (x, y, choice), Talk(speak=0.0), rng)

    def _walk(self, habit: Habit, rng: np.random.Generator, world: GridSettings) -> tuple[IntArray, IntArray, IntArray]:
        """Return columns and rows by state, (T + 1,), and choices by step, (T,)."""
        cells, choices = [_start(rng, world)], []
        own = way = int(rng.choice(4, p=habit.ways))
        for step in range(world.steps):
            if not (habit.keep == 1 or rng.random() < habit.keep):
                way = own if habit.own else int(rng.choice(4, p=habit.ways))
            legal = legal_moves(*np.array(cells[-1]), world)
            if not legal[way] and habit.edge != ON:
                way = way ^ 1 if habit.edge == BACK else int(rng.choice(np.flatnonzero(legal)))
            choice = STAY if rng.random() < habit.stay else STAY + 1 + way
            if habit.cycle:
                choice = habit.cycle[step % len(habit.cycle)]
            moves = choice != STAY and bool(legal[choice - STAY - 1])
            cells.append(cells[-1] + HEADINGS[choice] if moves else cells[-1])
            choices.append(choice)
        x, y = np.array(cells).T
        return x, y, np.array(choices, dtype=np.int64)


def _start(rng: np.random.Generator, world: GridSettings) -> IntArray:
    """Return a cell outside all places, each as likely."""
    while True:
        cell = rng.integers(-world.half_size, world.half_size, size=2, endpoint=True)
        if world.areas(cell[:1], cell[1:])[0] < 0:
            return np.asarray(cell)


def placed(world: GridSettings, seed: int) -> GridSettings:
    """Return the world of a seed, its positions drawn where that is its rule."""
    if not world.draw_positions:
        return world
    extents = np.array([place.extent for place in world.places])
    drawn = PositionLaw(world.half_size, extents, len(world.fires)).draw(seeding.stream(seed, "positions"))
    pairs = zip(world.places, drawn.places.tolist(), strict=True)
    places = tuple(msgspec.structs.replace(place, center=tuple(center)) for place, center in pairs)
    burning = zip(world.fires, drawn.fires.tolist(), strict=True)
    fires = tuple(msgspec.structs.replace(fire, position=tuple(position)) for fire, position in burning)
    return msgspec.structs.replace(world, places=places, fires=fires)


def world_of(agents: int, **changes: bool) -> GridSettings:
    """Return the world of the blind agents with so many of these."""
    return msgspec.structs.replace(WORLD, agents=agents, **changes)


_STRAIGHT, _STREAKS = Habit(), Habit(keep=0.9)
_SQUARE = tuple(way for way in (1, 4, 2, 3) for _ in range(5))
"""Up, right, down and left, five steps each."""

HABITS: Mapping[str, Crowd] = {
    "straight, turns at the edge": Crowd((_STRAIGHT,)),
    "straight, turns back": Crowd((replace(_STRAIGHT, edge=BACK),)),
    "straight, stuck at the edge": Crowd((replace(_STRAIGHT, edge=ON),)),
    "straight, all to the right": Crowd((replace(_STRAIGHT, ways=(0, 0, 0, 1), edge=ON),)),
    "a way of its own": Crowd((Habit(keep=0.0, own=True, edge=ON, stay=0.3),)),
    "mostly a way of its own": Crowd((Habit(keep=0.5, own=True),)),
    "keeps its way 9 of 10": Crowd((_STREAKS,)),
    "keeps its way 1 of 2, mostly up": Crowd((Habit(keep=0.5, ways=(0.7, 0.1, 0.1, 0.1)),)),
    "cycles in a square": Crowd((Habit(cycle=_SQUARE),)),
    "to and fro": Crowd((Habit(cycle=(4, 4, 4, 3, 3, 3)),)),
    "goes and rests": Crowd((Habit(cycle=(1, 1, 1, 1, 0, 0, 0, 0)),)),
    "half goes straight, half stays": Crowd((_STRAIGHT, Habit(stay=1.0))),
    "half goes straight, half draws": Crowd((_STRAIGHT, Habit(keep=0.0))),
    "all kinds": Crowd((_STRAIGHT, _STREAKS, Habit(cycle=_SQUARE), Habit(keep=0.0, stay=0.5))),
}
