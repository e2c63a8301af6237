"""The El Farol bar problem: a bar that is fun unless more than a share of all go; and a policy for it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from numpy.random import Generator

from foundry.declared import Actions
from foundry.errors import InputError
from foundry.models.scripted.base import ScriptedModel
from foundry.worlds.rounds.replies import deciding
from foundry.worlds.rounds.table import Table
from foundry.worlds.rounds.world import Play, RoundsScenario

REPORTS = ("explicit", "implicit")


class ElFarol(RoundsScenario):
    """A configured bar.

    Description:
        All decide at once, every evening, whether to go. The bar is crowded when more than `crowded` of all go.

    Observation:
        `crowded`, and `evenings`: of each so far `went` (how many; null where one is not told), `action` and `utility`
        of one's own. Where reports are `explicit` all are told how many went, where `implicit` only those who did.

    Questions:
        `evening`, to all at once.

    Actions:
        `go` or `stay`; a reply that cannot be read counts as `stay`.

    Termination:
        After `steps` evenings.

    Source:
        W. B. Arthur, American Economic Review 84 (1994); payoffs and reports as in GAMABench (games/bar_game.py).
    """

    kinds: ClassVar[tuple[str, ...]] = ("evening",)

    def __init__(self, *, crowded: float, fun: float, dull: float, home: float, reports: str, **settings: Any) -> None:
        """Set the payoffs of a good and of a crowded bar and of staying, and who is told how many went."""
        super().__init__(**settings)
        if reports not in REPORTS:
            raise InputError(f"world.reports={reports} is not known: choose {' or '.join(REPORTS)}.")
        self.crowded, self.explicit = crowded, reports == "explicit"
        self.payoffs = {True: fun, False: dull}, home

    def actions(self) -> dict[str, Actions]:
        """Return what can be decided."""
        return {"evening": Actions(labels=("go", "stay"), idle="stay")}

    def play(self, table: Table) -> Play:
        """Play the evenings."""
        at_the_bar, at_home = self.payoffs
        known: list[list[dict[str, Any]]] = [[] for _ in table.agents]
        for _ in table.rounds(self.steps):
            decisions = yield [
                table.ask(agent, "evening", crowded=self.crowded, evenings=list(known[agent])) for agent in table.agents
            ]
            went = sum(one.taken == "go" for one in decisions)
            for one in decisions:
                goes = one.taken == "go"
                utility = at_the_bar[went <= self.crowded * self.agents] if goes else at_home
                table.record(one, utility=utility)
                told = went if self.explicit or goes else None
                known[one.agent].append({"went": told, "action": one.taken, "utility": utility})


class Mixing(ScriptedModel):
    """Goes with the same probability every evening: the symmetric equilibrium, for the right one."""

    def __init__(self, name: str, probability: float) -> None:
        super().__init__(name)
        self._probability = probability

    def evening(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Draw whether to go."""
        return deciding("go" if rng.random() < self._probability else "stay")

    def parameters(self) -> dict[str, Any]:
        """Return the policy and its probability."""
        return super().parameters() | {"probability": self._probability}
