"""Public goods: the sum of contributions is multiplied and shared, yet each agent gains most by giving nothing."""

import math
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, TypeAlias

from foundry.declared import Actions
from foundry.records import Agent, Message, Record, RoundStep
from foundry.worlds.base import Question
from foundry.worlds.rounds.rounds_world import Play, RoundsScenario
from foundry.worlds.rounds.table import Decision, Table
from foundry.worlds.validation import check_flag, check_number

GIVE, PUNISH = "contribution", "punishment"
NOBODY = "nobody"


class Giving(RoundStep, frozen=True, kw_only=True):
    """A decision of the public goods game (`steps.jsonl`).

    Attributes:
        tokens: tokens that the agent could give; null for decisions about punishment.
    """

    tokens: float | None = None


class Pot(Record, frozen=True, kw_only=True):
    """The pot of a round (`pot.jsonl`).

    Attributes:
        step: 1-based round.
        given: tokens that all agents gave.
        returned: tokens that all agents got back.
    """

    stream: ClassVar[str] = "pot"

    step: int
    given: int
    returned: float


@dataclass(frozen=True)
class After:
    """An agent's tokens after a round, and keys that its later observations show for this round."""

    tokens: float
    told: Mapping[str, Any] = field(default_factory=dict)


Afterwards: TypeAlias = Generator[Sequence[Question], list[Decision], list[After]]
"""Generator that yields the questions after the contributions of a round, receives the decisions, and returns each
agent's result.
"""


class PublicGoods(RoundsScenario):
    """A common pot that is worth more to the group than to each agent.

    Description:
        Every round each agent gives some of its tokens to a pot. The pot is multiplied and shared equally. With `reset`
        every agent has `tokens` again in every round; without it, agents keep their tokens.

    Observation:
        `tokens` (the agent's own), `multiplier`, `reset`, `cost` and `loss` (null). `rounds`: for each round so far,
        oldest first, the agent's own `given` and `payoff`, and `pot`, the sum of all contributions.

    Questions:
        `contribution`, to all agents at once.

    Actions:
        A whole number of the agent's tokens. An unreadable reply gives nothing.

    Termination:
        After `steps` rounds.

    Source:
        GAMABench, Huang et al. 2024 (games/public_goods.py), after Isaac, Walker and Thomas 1984. Game, numbers and
        score are as in GAMABench; the prompts and `reset: false` are foundry's own. GAMABench's leaderboard gives
        scores of 19.6 (llama3.1:8b) to 90.9 (gpt-4o).
    """

    kinds: ClassVar[tuple[str, ...]] = (GIVE,)
    records: ClassVar[tuple[type[Record], ...]] = (Giving, Message, Agent, Pot)

    def __init__(self, *, tokens: int, multiplier: float, reset: bool, **settings: Any) -> None:
        super().__init__(**settings)
        check_number("world.tokens", tokens, 1, whole=True)
        check_number("world.multiplier", multiplier, 0)
        check_flag("world.reset", reset)
        self.tokens, self.multiplier, self.reset = tokens, multiplier, reset
        self.told: dict[str, Any] = {"multiplier": multiplier, "reset": reset, "cost": None, "loss": None}

    def actions(self) -> dict[str, Actions]:
        """Return the possible decisions."""
        return {GIVE: Actions(low=0, high=self.tokens if self.reset else None, idle=0)}

    def payoffs(self, question: Question) -> list[float]:
        """Return the agent's payoffs of earlier rounds, as its prompt shows them."""
        return [played["payoff"] for played in question.observation.get("rounds", ())]

    def play(self, table: Table) -> Play:
        """Play the rounds."""
        tokens: list[float] = [self.tokens] * self.agents
        known: list[list[dict[str, Any]]] = [[] for _ in table.agents]
        for step in table.rounds(self.steps):
            decisions = yield [self._asked(table, agent, tokens[agent], known[agent]) for agent in table.agents]
            given = [int(decision.taken) for decision in decisions]
            back = self.multiplier * sum(given) / self.agents
            table.write(Pot(step=step, given=sum(given), returned=self.multiplier * sum(given)))
            left = [had - gave + back for had, gave in zip(tokens, given, strict=True)]
            after = yield from self.afterwards(table, given, left)
            for decision, had, has in zip(decisions, tokens, after, strict=True):
                payoff = has.tokens if self.reset else has.tokens - had
                table.record(decision, utility=payoff, tokens=had)
                details = {"given": int(decision.taken), "pot": sum(given), "payoff": payoff}
                known[decision.agent].append(details | dict(has.told))
            tokens = [self.tokens if self.reset else has.tokens for has in after]

    def _asked(self, table: Table, agent: int, tokens: float, rounds: Sequence[dict[str, Any]]) -> Question:
        legal = Actions(low=0, high=math.floor(tokens), idle=0)
        return table.ask(agent, GIVE, legal=legal, **self.told, tokens=tokens, rounds=list(rounds))

    def afterwards(self, table: Table, given: Sequence[int], left: Sequence[float]) -> Afterwards:
        """Play the part of a round after the contributions; return each agent's result. By default, nothing follows.

        Args:
            table: the episode.
            given: contribution of each agent.
            left: tokens of each agent, including its share of the pot.
        """
        yield from ()
        return [After(tokens) for tokens in left]


class PunishedGoods(PublicGoods):
    """The public goods game with punishment: agents see all contributions, and may pay to punish another agent.

    Description:
        As `PublicGoods`. After the contributions, each agent may punish one other agent. A punishment costs the agent
        `cost` tokens and takes `loss` tokens from the other, or all tokens if it has fewer.

    Observation:
        As `PublicGoods`, with `cost` and `loss`. `rounds` also has `punished` (the agent that it punished, or null) and
        `punished_by` (number of agents that punished it). For a `punishment`: `given` (each contribution by agent id),
        `tokens` (the agent's own), `multiplier`, `reset`, `cost`, `loss`.

    Questions:
        `contribution`, to all agents at once; then `punishment`, to all agents at once.

    Actions:
        `contribution`: as `PublicGoods`. `punishment`: `nobody`, or `agent <id>` of another agent. An unreadable reply
        punishes nobody. An agent with fewer than `cost` tokens cannot punish.

    Termination:
        After `steps` rounds.

    Source:
        E. Fehr and S. Gächter, Cooperation and punishment in public goods experiments, American Economic Review 90
        (2000), and Altruistic punishment in humans, Nature 415 (2002), in which a unit of punishment costs 1 and takes
        3. In the article in Nature, groups of four change from round to round, and a member may get up to ten units
        from another. In this world, one group stays together, and each agent may punish one other agent once.
    """

    kinds: ClassVar[tuple[str, ...]] = (GIVE, PUNISH)

    def __init__(self, *, cost: float, loss: float, **settings: Any) -> None:
        super().__init__(**settings)
        check_number("world.cost", cost, 0)
        check_number("world.loss", loss, 0)
        self.cost, self.loss = cost, loss
        self.told |= {"cost": cost, "loss": loss}

    def actions(self) -> dict[str, Actions]:
        """Return the possible decisions."""
        return super().actions() | {PUNISH: whom(range(self.agents))}

    def afterwards(self, table: Table, given: Sequence[int], left: Sequence[float]) -> Afterwards:
        """Ask each agent whom it punishes; subtract the punisher's cost and the punished agent's loss."""
        details: dict[str, Any] = {**self.told, "given": list(given)}
        decisions = yield [
            table.ask(agent, PUNISH, legal=self._legal(agent, left[agent]), tokens=left[agent], **details)
            for agent in table.agents
        ]
        whom_each = [None if decision.taken == NOBODY else agent_of(decision.taken) for decision in decisions]
        return [After(*settled) for settled in self._settled(left, whom_each)]

    def _legal(self, agent: int, tokens: float) -> Actions:
        return whom(other for other in range(self.agents) if other != agent and tokens >= self.cost)

    def _settled(
        self, left: Sequence[float], whom_each: Sequence[int | None]
    ) -> Iterator[tuple[float, dict[str, Any]]]:
        """Yield, for each agent, its tokens after all punishments, whom it punished, and how many punished it."""
        for agent, tokens in enumerate(left):
            paid = self.cost if whom_each[agent] is not None else 0
            times = sum(target == agent for target in whom_each)
            rest = tokens - paid
            yield rest - min(times * self.loss, rest), {"punished": whom_each[agent], "punished_by": times}


def whom(agents: Iterable[int]) -> Actions:
    """Return the decisions to punish nobody, or one of the given agents."""
    return Actions(labels=(NOBODY, *(f"agent {agent}" for agent in agents)), idle=NOBODY)


def agent_of(label: str) -> int:
    """Return the agent's id in an action such as `agent 3`."""
    return int(label.removeprefix("agent "))
