"""Runs of any form whose policies are known exactly: what the measures of every form must say of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.random import Generator

from analysis.any.any_arrays import objects
from analysis.any.any_run import AnyRun
from analysis.arrays import OUTCOMES, IntArray
from foundry import seeding
from foundry.declared import Actions, Declared
from foundry.records import Outcome

LABELS = ("go", "stay", "wait")
CHOICE = Declared(
    form="ring",
    actions={"choice": Actions(labels=LABELS, idle="stay")},
    streams={"steps": {"step": "integer", "utility": "number?", "message": "text?"}},
)
BID = Declared(form="ring", actions={"bid": Actions(whole=False)}, streams={"steps": {"step": "integer"}})


def any_run(
    rows: Sequence[tuple[int, int, Any]],
    *,
    kind: str | Sequence[str] = "choice",
    declared: Declared = CHOICE,
    personas: Sequence[Mapping[str, str]] = (),
    **changes: Any,
) -> AnyRun:
    """Return a run of decisions (step, agent, action), in this order."""
    size = len(rows)
    agents = max([len(personas), *(agent + 1 for _, agent, _ in rows)])
    actions = [action for _, _, action in rows]
    fields: dict[str, Any] = {
        "id": "run", "declared": declared, "agents": agents,
        "step": np.array([step for step, _, _ in rows], dtype=np.int64),
        "agent": np.array([agent for _, agent, _ in rows], dtype=np.int64),
        "kind": objects([kind] * size if isinstance(kind, str) else kind),
        "action": objects(action if isinstance(action, str) else None for action in actions),
        "number": np.array([np.nan if isinstance(did, str | None) else did for did in actions], dtype=np.float64),
        "outcome": np.full(size, OUTCOMES.index(Outcome.CHOSEN)), "utility": np.full(size, np.nan),
        "said": np.full(size, None, dtype=np.object_), "deliveries": np.zeros((0, 3), dtype=np.int64),
        "personas": (*personas, *({} for _ in range(agents - len(personas)))),
    }  # fmt: skip
    return AnyRun(**{**fields, **changes})


@dataclass(frozen=True)
class Crowd:
    """Agents that act by known chances and get what luck gives them."""

    shares: Sequence[Sequence[float]] = ((0.5, 0.3, 0.2),)
    steps: int = 24
    agents: int = 8
    mood: float = 0.0
    habit: float = 0.0
    quota: bool = False
    present: Sequence[float] = (1.0,)
    lost: float = 0.0
    turns: bool = False
    groups: Sequence[str] | int = 3

    def play(self, seed: int) -> AnyRun:
        stream = seeding.stream(seed, "crowd")
        drawn = self._actions(stream)
        here = stream.random(drawn.shape) < np.resize(self.present, self.agents)
        if self.turns:
            here &= np.arange(self.steps)[:, None] % self.agents == np.arange(self.agents)
        lost = stream.random(drawn.shape) < self.lost
        cells = np.argwhere(here).tolist()
        run = any_run(
            [(t + 1, i, None if lost[t, i] else LABELS[drawn[t, i]]) for t, i in cells], personas=self._personas(stream)
        )
        outcomes = [OUTCOMES.index(Outcome.EMPTY if lost[t, i] else Outcome.CHOSEN) for t, i in cells]
        luck = stream.normal(size=len(cells))
        return replace(run, outcome=np.array(outcomes, dtype=np.int64), utility=luck)

    def _actions(self, stream: Generator) -> IntArray:
        shares = np.resize(np.array(self.shares), (self.agents, len(LABELS)))
        found = np.zeros((self.steps, self.agents), dtype=np.int64)
        for step in range(self.steps):
            chances = (1 - self.mood) * shares + self.mood * stream.dirichlet([0.3] * len(LABELS))
            fresh = (stream.random((self.agents, 1)) > chances.cumsum(axis=1)[:, :-1]).sum(axis=1)
            if self.quota:
                fresh = stream.permutation(np.repeat(np.arange(3), np.round(shares[0] * self.agents).astype(int)))
            again = (stream.random(self.agents) < self.habit) & (step > 0)
            found[step] = np.where(again, found[step - 1], fresh)
        return found

    def _personas(self, stream: Generator) -> list[dict[str, str]]:
        if isinstance(self.groups, int):
            return [{"role": str(integer)} for integer in stream.integers(self.groups, size=self.agents)]
        return [{"role": group} for group in self.groups]


CROWDS = {
    "one by one": Crowd(),
    "all in one mood": Crowd(mood=0.8),
    "in habits": Crowd(habit=0.6, steps=36),
    "as many as there is room": Crowd(quota=True, shares=((0.5, 0.25, 0.25),)),
    "each as often as it likes": Crowd(present=(0.2, 0.4, 0.6, 0.8, 1, 1, 1, 1), mood=0.5),
    "in turns": Crowd(turns=True, steps=120, agents=4),
    "few": Crowd(agents=3, steps=12),
    "with lost replies": Crowd(lost=0.3, mood=0.3),
}
"""Crowds whose agents are alike, and draw their personas by lot."""
