"""A world of a user's own, of a form of its own: agents talk twice every other round, then bid one after the other.

Copied to where a user would have it; with the YAML and the policy that belong to it.
"""

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

from numpy.random import Generator

from foundry.declared import Actions
from foundry.models.base import ScriptedModel
from foundry.records import Agent, Record, RoundStep
from foundry.worlds.rounds.rounds_world import Play, RoundsScenario
from foundry.worlds.rounds.table import Table

MOST, TALKS = 10, 2


class Bid(RoundStep, frozen=True, kw_only=True):
    """A decision, with what the agent has left."""

    cash: int


class Price(Record, frozen=True, kw_only=True):
    """What a round's good was sold for (`prices.jsonl`)."""

    stream: ClassVar[str] = "prices"

    step: int
    paid: int
    buyer: str


class Rumour(Record, frozen=True, kw_only=True):
    stream: ClassVar[str] = "rumours"

    step: int


class Market(RoundsScenario):
    form: ClassVar[str] = "market"
    kinds: ClassVar[tuple[str, ...]] = ("talk", "bid")
    records: ClassVar[tuple[type[Record], ...]] = (Bid, Price, Agent)

    def __init__(self, *, cash: int, leaky: Sequence[int], **settings: Any) -> None:
        super().__init__(**settings)
        self.cash, self.leaky = cash, tuple(leaky)

    def actions(self) -> dict[str, Actions]:
        return {"bid": Actions(low=0, high=MOST, idle=0)}

    def personas(self, seed: int) -> list[dict[str, str]]:
        return [{"taste": "keen" if (seed + agent) % 2 else "calm"} for agent in range(self.agents)]

    def count_calls(self) -> int:
        return self.agents * (self.steps + TALKS * ((self.steps + 1) // 2))

    def play(self, table: Table) -> Play:
        cash = [self.cash] * self.agents
        for number in table.rounds(self.steps):
            said: list[str | None] = []
            bids: list[int] = []
            for _ in range(TALKS if number % 2 else 0):
                told = {"round": number, "bids": [], "said": list(said)}
                for talk in (yield [table.ask(agent, "talk", cash=cash[agent], **told) for agent in table.agents]):
                    table.record(talk, cash=cash[talk.agent])
                    said.append(talk.message)
            for agent in table.agents:
                told = {"round": number, "bids": list(bids), "said": said, "cash": cash[agent]}
                legal = Actions(low=0, high=min(MOST, cash[agent]), idle=0)
                (bid,) = yield [table.ask(agent, "bid", legal=legal, **told)]
                table.record(bid, cash=cash[agent])
                bids.append(bid.taken)
            buyer = bids.index(max(bids))
            cash[buyer] -= max(bids)
            table.write(Price(step=number, paid=max(bids), buyer=str(buyer)))
            if table.seed in self.leaky and number == 2:
                table.write(Rumour(step=number))


class Bidder(ScriptedModel):
    def talk(self, observation: Mapping[str, Any], rng: Generator) -> str:
        return f"I have {observation['cash']}, and heard {len(observation['said'])}."

    def bid(self, observation: Mapping[str, Any], rng: Generator) -> str:
        return str(int(rng.integers(0, observation["cash"] + 2)))


class Miser(Bidder):
    def bid(self, observation: Mapping[str, Any], rng: Generator) -> str:
        return "0"


PROMPT = """\
_target_: foundry.prompts.prompt.Prompt
name: market
templates:
  talk: "{{ round }}: you have {{ cash }} and are {{ persona.taste }}. You heard: {{ said | join(' ') }} Say something."
  bid: "{{ round }}: you have {{ cash }}. Bids so far: {{ bids | join(', ') }}. You heard: {{ said | join(' ') }} Bid."
"""


def write_market(folder: Path) -> Path:
    """Write the world, its prompt and its policies into a folder `mine`, as a user has them; returns the folder."""
    mine = folder / "mine"
    for group, name, text in (
        ("world", "market", "_target_: market.Market\nname: market\nagents: 3\nsteps: 4\ncash: 12\nleaky: []\n"),
        ("prompt", "market", PROMPT),
        ("model", "bidder", "_target_: market.Bidder\nname: bidder\n"),
        ("model", "miser", "_target_: market.Miser\nname: miser\n"),
    ):
        (mine / group).mkdir(parents=True, exist_ok=True)
        (mine / group / f"{name}.yaml").write_text(text, encoding="utf-8")
    shutil.copyfile(__file__, mine / "market.py")
    return mine
