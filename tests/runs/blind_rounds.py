"""Runs of games whose agents look at nothing, by chances that are known exactly."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.random import Generator

from analysis.any.arrays import objects
from analysis.arrays import FloatArray
from analysis.rounds.run import RoundsRun
from blind_any_runs import any_run
from foundry import seeding
from foundry.declared import Actions, Declared

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
        """Return one run."""
        stream = seeding.stream(seed, "goers")
        goes = _in_habits(
            stream, stream.random((ROUNDS, AGENTS)) < stream.uniform(self.low, self.high, AGENTS), self.habit
        )
        return _run(EVENING, np.where(goes, "go", "stay").tolist(), {"capacity": 0.6})


@dataclass(frozen=True)
class Givers:
    """Agents that give anything from nothing to their own most, and with a chance what they gave last."""

    habit: float = 0.0

    def play(self, seed: int) -> RoundsRun:
        """Return one run."""
        stream = seeding.stream(seed, "givers")
        most = stream.integers(TOKENS + 1, size=AGENTS)
        given = _in_habits(stream, stream.integers(most + 1, size=(ROUNDS, AGENTS)), self.habit)
        run = _run(GIVING, given.tolist(), {"tokens": TOKENS, "multiplier": 2, "reset": True})
        return replace(run, columns={"tokens": objects([TOKENS] * run.decisions)})


GOERS: Mapping[str, Any] = {
    "goes as a coin falls": Goers(0.5, 0.5),
    "goes by its own odds": Goers(0.0, 1.0),
    "goes in habits": Goers(0.3, 0.9, habit=0.5),
}
GIVERS: Mapping[str, Any] = {"gives anything": Givers(), "gives in habits": Givers(habit=0.5)}


def _in_habits(stream: Generator, fresh: Any, habit: float) -> FloatArray:
    """Return decisions (T, N) of which each is with this chance the one before."""
    for step in range(1, len(fresh)):
        fresh[step] = np.where(stream.random(AGENTS) < habit, fresh[step - 1], fresh[step])
    return np.asarray(fresh)


def _run(declared: Declared, actions: Any, world: Mapping[str, Any]) -> RoundsRun:
    (kind,) = declared.actions
    rows = [(step, agent, one) for step, row in enumerate(actions, 1) for agent, one in enumerate(row)]
    return RoundsRun.of(any_run(rows, kind=kind, declared=declared, world=world))
