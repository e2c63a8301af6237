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
from foundry.records import Agent, Outcome, Record, RoundStep
from foundry.worlds.base import Answer, Question, Recorded, Redrawing, Scenario, World, undecided_outcome

MOST, TALKS = 10, 2
PNG = b"\x89PNG of round %d"


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
    """What the world does not say that it writes."""

    stream: ClassVar[str] = "rumours"

    step: int


class Market(Scenario):
    """A good a round, sold to who bids most."""

    form: ClassVar[str] = "market"
    kinds: ClassVar[tuple[str, ...]] = ("talk", "bid")
    records: ClassVar[tuple[type[Record], ...]] = (Bid, Price, Agent)

    def __init__(self, name: str, agents: int = 3, steps: int = 4, cash: int = 12, leaky: Sequence[int] = ()) -> None:
        self.name, self.agents, self.steps, self.cash, self.leaky = name, agents, steps, cash, tuple(leaky)

    def start(self, seed: int) -> "MarketWorld":
        return MarketWorld(self, seed)

    def redraw(self, recorded: Recorded) -> Redrawing:
        return MarketPictures()

    def actions(self) -> dict[str, Actions]:
        return {"bid": Actions(low=0, high=MOST, idle=0)}

    def personas(self, seed: int) -> list[Mapping[str, str]]:
        return [{"taste": "keen" if (seed + agent) % 2 else "calm"} for agent in range(self.agents)]

    def count_calls(self) -> int:
        return self.agents * (self.steps + TALKS * ((self.steps + 1) // 2))


class MarketPictures(Redrawing):
    """Pictures of a market."""

    def draw(self, step: int) -> bytes:
        return PNG % step


class MarketWorld(World):
    """One market; in odd rounds all talk at once first, twice, then each bids, and knows what was bid before."""

    def __init__(self, scenario: Market, seed: int) -> None:
        self._scenario, self._seed = scenario, seed
        self._personas = scenario.personas(seed)
        self._cash = [scenario.cash] * scenario.agents
        self._said: list[str] = []
        self._bids: list[int] = []
        self._round = 0

    @property
    def step(self) -> int:
        return self._round

    @property
    def finished(self) -> bool:
        return self._round == self._scenario.steps

    def opening(self) -> list[Record]:
        return [Agent(agent=agent, persona=dict(persona)) for agent, persona in enumerate(self._personas)]

    def pending(self) -> list[Question]:
        if self.finished:
            return []
        if self._talking:
            return [self._question(agent, "talk") for agent in range(self._scenario.agents)]
        return [self._question(len(self._bids), "bid")]

    @property
    def _talking(self) -> bool:
        return self._round % 2 == 0 and len(self._said) < TALKS * self._scenario.agents

    def _question(self, agent: int, kind: str) -> Question:
        told = {"round": self._round + 1, "cash": self._cash[agent], "bids": list(self._bids), "said": list(self._said)}
        return Question(self._round + 1, agent, kind, {**told, "persona": self._personas[agent]}, idle="0")

    def advance(self, answers: Sequence[Answer]) -> list[Record]:
        if self._talking:
            said = [answer.text.strip() for answer in answers]
            self._said += said
            return [self._record(agent, "talk", None, Outcome.CHOSEN, message=text) for agent, text in enumerate(said)]
        (answer,) = answers
        agent, text = len(self._bids), answer.text.strip()
        readable = text.isdigit() and int(text) <= min(MOST, self._cash[agent])
        self._bids.append(int(text) if readable else 0)
        outcome = Outcome.CHOSEN if readable else undecided_outcome(answer)
        record = self._record(agent, "bid", self._bids[-1] if readable else None, outcome)
        return [record, *(self._sell() if len(self._bids) == self._scenario.agents else ())]

    def _record(self, agent: int, kind: str, action: int | None, outcome: Outcome, message: str | None = None) -> Bid:
        step, cash = self._round + 1, self._cash[agent]
        return Bid(step=step, agent=agent, kind=kind, action=action, outcome=outcome, message=message, cash=cash)

    def _sell(self) -> list[Record]:
        paid = max(self._bids)
        buyer = self._bids.index(paid)
        self._cash[buyer] -= paid
        self._round, self._said, self._bids = self._round + 1, [], []
        leaks = self._seed in self._scenario.leaky and self._round == 2
        sold: list[Record] = [Price(step=self._round, paid=paid, buyer=str(buyer))]
        return [*sold, *([Rumour(step=self._round)] if leaks else [])]

    def draw(self) -> bytes:
        return PNG % self._round


class Bidder(ScriptedModel):
    """Bids what it likes."""

    def talk(self, observation: Mapping[str, Any], rng: Generator) -> str:
        return f"I have {observation['cash']}, and heard {len(observation['said'])}."

    def bid(self, observation: Mapping[str, Any], rng: Generator) -> str:
        return str(int(rng.integers(0, observation["cash"] + 2)))


class Miser(Bidder):
    """Bids nothing."""

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
