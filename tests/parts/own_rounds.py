"""Worlds of rounds as users would write them: at once and in turn, with talk, personas, own keys and an early end."""

from __future__ import annotations

from typing import Any, ClassVar

from foundry.declared import Actions
from foundry.records import Agent, Message, Record, RoundStep
from foundry.worlds.rounds.table import Table
from foundry.worlds.rounds.world import Play, RoundsScenario


class Bar(RoundsScenario):
    """All decide at once whether to go."""

    kinds: ClassVar[tuple[str, ...]] = ("evening",)

    def __init__(self, *, crowded: float = 0.6, **settings: Any) -> None:
        super().__init__(**settings)
        self.crowded = crowded

    def actions(self) -> dict[str, Actions]:
        return {"evening": Actions(labels=("go", "stay"), idle="stay")}

    def play(self, table: Table) -> Play:
        went = None
        for _ in table.rounds(self.steps):
            decisions = yield [table.ask(agent, "evening", went=went) for agent in table.agents]
            went = sum(one.taken == "go" for one in decisions)
            fun = 10 if went <= self.crowded * self.agents else 0
            for one in decisions:
                table.record(one, utility=5 if one.taken == "stay" else fun)


class Catch(RoundStep, frozen=True, kw_only=True):
    """A catch knows what was left."""

    stock: int | None = None


class Stock(Record, frozen=True, kw_only=True):
    """The fish after a month."""

    stream: ClassVar[str] = "stock"

    step: int
    fish: int


class Fishery(RoundsScenario):
    """All catch at once, then talk one after another in drawn order; the end comes with the last fish."""

    kinds: ClassVar[tuple[str, ...]] = ("catch", "talk")
    records: ClassVar[tuple[type[Record], ...]] = (Catch, Message, Agent, Stock)

    def __init__(self, *, stock: int = 100, **settings: Any) -> None:
        super().__init__(**settings)
        self.stock = stock

    def actions(self) -> dict[str, Actions]:
        return {"catch": Actions(low=0, high=self.stock, idle=0)}

    def play(self, table: Table) -> Play:
        fish = self.stock
        for month in table.rounds(self.steps):
            legal = Actions(low=0, high=fish, idle=0)
            catches = yield [table.ask(agent, "catch", legal=legal, fish=fish) for agent in table.agents]
            caught = sum(one.taken for one in catches)
            for one in catches:
                table.record(one, utility=one.taken, stock=fish)
            for agent in table.stream(f"order {month}").permutation(self.agents).tolist():
                (said,) = yield [table.ask(agent, "talk", caught=caught)]
                table.tell(agent, [other for other in table.agents if other != agent], said.message)
            fish = min(2 * max(fish - caught, 0), self.stock)
            table.write(Stock(step=month, fish=fish))
            if fish < 5:
                return


class Silent(Bar):
    """A game that says neither what is legal nor what does nothing."""

    def actions(self) -> dict[str, Actions]:
        return {"evening": Actions(low=0)}
