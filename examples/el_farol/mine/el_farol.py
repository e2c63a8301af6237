"""The El Farol bar problem: a bar that is fun unless more than a share of all go; and a policy for it."""

import json
from collections.abc import Mapping
from typing import Any, ClassVar

from numpy.random import Generator

from foundry import Actions, InputError, Play, RoundsScenario, ScriptedModel, Table


class ElFarol(RoundsScenario):
    """A configured bar.

    Description:
        All decide at once, every evening, whether to go to a bar. It is crowded when more than `crowded` of all go.

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
        super().__init__(**settings)
        if reports not in ("explicit", "implicit"):
            raise InputError(f"world.reports={reports} is not known: choose explicit or implicit.")
        self.crowded, self.explicit = crowded, reports == "explicit"
        self.fun, self.dull, self.home = fun, dull, home

    def actions(self) -> dict[str, Actions]:
        """Return what can be decided."""
        return {"evening": Actions(labels=("go", "stay"), idle="stay")}

    def play(self, table: Table) -> Play:
        """Play the evenings."""
        known: list[list[dict[str, Any]]] = [[] for _ in table.agents]
        for _ in table.rounds(self.steps):
            shown = [{"crowded": self.crowded, "evenings": list(evenings)} for evenings in known]
            decisions = yield [table.ask(agent, "evening", **shown[agent]) for agent in table.agents]
            went = sum(decision.taken == "go" for decision in decisions)
            at_the_bar = self.fun if went <= self.crowded * self.agents else self.dull
            for decision in decisions:
                goes = decision.taken == "go"
                utility = at_the_bar if goes else self.home
                table.record(decision, utility=utility)
                told = went if self.explicit or goes else None
                known[decision.agent].append({"went": told, "action": decision.taken, "utility": utility})


class Mixing(ScriptedModel):
    """Goes with the same probability every evening: the symmetric equilibrium, for the right one."""

    def __init__(self, name: str, probability: float) -> None:
        super().__init__(name, probability=probability)
        self._probability = probability

    def evening(self, observation: Mapping[str, Any], rng: Generator) -> str:
        """Draw whether to go."""
        return json.dumps({"action": "go" if rng.random() < self._probability else "stay"})
