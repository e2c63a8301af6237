"""The world part_name: change its rules to yours."""

from collections.abc import Mapping
from typing import ClassVar

from foundry import Actions, Play, RoundsScenario, Table


class PartName(RoundsScenario):
    """A game in rounds, in which agents give tokens.

    Description:
        In every round all agents decide at the same time how many of their tokens to give. The gifts are doubled and
        shared equally among all.

    Observation:
        `given`: total gifts of the round before, or None; and the observations of every world of rounds.

    Questions:
        One `gift` question per agent and round.

    Actions:
        A whole number from 0 to `tokens`; giving 0 does nothing.

    Termination:
        After `steps` rounds.
    """

    kinds: ClassVar[tuple[str, ...]] = ("gift",)

    def __init__(self, *, name: str, agents: int, steps: int, tokens: int) -> None:
        super().__init__(name=name, agents=agents, steps=steps)
        self.tokens = tokens

    def actions(self) -> Mapping[str, Actions]:
        """Return the possible decisions, by kind of question."""
        return {"gift": Actions(low=0, high=self.tokens, idle=0)}

    def play(self, table: Table) -> Play:
        """Play one episode: ask all, then record each agent's gift and payoff."""
        given = None
        for _ in table.rounds(self.steps):
            decisions = yield [table.ask(agent, "gift", given=given, tokens=self.tokens) for agent in table.agents]
            given = sum(int(decision.taken) for decision in decisions)
            for answer in decisions:
                table.record(answer, utility=self.tokens - int(answer.taken) + 2 * given / self.agents)
