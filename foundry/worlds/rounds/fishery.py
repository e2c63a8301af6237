"""The fishery: agents catch fish from a common stock that grows back, and talk about it."""

from __future__ import annotations

from collections import abc
from collections.abc import Mapping, Sequence
from itertools import cycle, islice
from typing import Any, ClassVar, TypeAlias

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from foundry.declared import Actions
from foundry.errors import InputError, not_found
from foundry.records import Agent, Message, Record, RoundStep
from foundry.worlds.base import Question
from foundry.worlds.rounds.rounds_world import Play, RoundsScenario
from foundry.worlds.rounds.table import Decision, Table
from foundry.worlds.validation import check_flag, check_number

CATCH, TALK = "catch", "talk"
STOCHASTIC, PROPORTIONAL = "stochastic", "proportional"
SHARINGS = (STOCHASTIC, PROPORTIONAL)
MOST = 10_000
"""Largest allowed stock, in tons."""

_Conversation: TypeAlias = abc.Generator[Sequence[Question], list[Decision], list[dict[str, Any]]]


class Catch(RoundStep, frozen=True, kw_only=True):
    """A decision of the fishery.

    Attributes:
        caught: tons that the agent got; null for talk.
    """

    caught: int | None = None


class Stock(Record, frozen=True, kw_only=True):
    """A month of the fishery, tons (`stock.jsonl`).

    Attributes:
        step: 1-based month.
        before: tons before the catch.
        caught: tons that all agents caught.
        outsider: tons that the outsider caught; null without an outsider.
        after: tons after the catch.
        next: tons at the start of the next month; null after a collapse.
    """

    stream: ClassVar[str] = "stock"

    step: int
    before: int
    caught: int
    outsider: int | None
    after: int
    next: int | None


class Fishery(RoundsScenario):
    """A lake that several agents fish, and may exhaust.

    Description:
        Each month all agents say at once how many tons they want to catch. If they want more than the stock, their
        catches are cut. `stochastic` gives each ton to a random agent that still wants some. `proportional` gives
        proportional shares, rounded down, and then the remaining tons at random to agents that were rounded down. After
        the catches, the group talks, and the remaining stock doubles, at most to its initial size. From some month on,
        a scripted outsider may fish too; it gets no questions and hears nothing.

    Observation:
        `stock`, `capacity` and `collapse` (tons). `months`: for each month so far `step`, `stock` before the catch,
        `caught` (by agent), `outsider` (null if there is none) and `left`. `talk`: the messages of the latest
        conversation, each with `agent` and `text`, including the agent's own. For a catch also `sustainable`: the tons
        that each agent may take so that the stock grows back, or null without `universalisation`. No prompt names the
        last month.

    Questions:
        `catch`, to all agents at once. After the catches, `talk`, to one agent after the other in a random order,
        repeatedly. The conversation ends after `talk` questions, or after every agent in turn was silent.

    Actions:
        A whole number of tons, 0 to the stock. An unreadable reply counts as 0.

    Termination:
        After `steps` months, or after the month in which fewer than `collapse` tons are left.

    Source:
        G. Piatti et al., arXiv 2404.16698 (GovSim, simulation/scenarios/common/environment/concurrent_env.py). Sharing,
        growth, collapse and efficiency are as in GovSim. The agents of GovSim remember and plan with further calls;
        here the prompt shows all months and the latest talk. Agents here talk in a random order, and talk changes no
        catch. GovSim reports that 43 of 45 pairs of model and scenario collapse.
    """

    kinds: ClassVar[tuple[str, ...]] = (CATCH, TALK)
    records: ClassVar[tuple[type[Record], ...]] = (Catch, Message, Agent, Stock)

    def __init__(
        self,
        *,
        stock: int,
        collapse: int,
        sharing: str,
        talk: int,
        universalisation: bool,
        outsider: Mapping[str, int] | None,
        **settings: Any,
    ) -> None:
        super().__init__(**settings)
        check_number("world.stock", stock, 1, MOST, whole=True)
        check_number("world.collapse", collapse, 0, stock, whole=True)
        check_number("world.talk", talk, 0, MOST, whole=True)
        check_flag("world.universalisation", universalisation)
        if sharing not in SHARINGS:
            raise not_found("world.sharing", str(sharing), SHARINGS)
        self.stock, self.collapse, self.sharing, self.talk = stock, collapse, sharing, talk
        self.universalisation = universalisation
        self._from, self._wanted = _outsider(outsider)

    def actions(self) -> dict[str, Actions]:
        """Return the possible decisions: catches from 0 to the whole stock, tons."""
        return {CATCH: Actions(low=0, high=self.stock, idle=0)}

    def count_calls(self) -> int:
        """Return the maximum number of calls in an episode."""
        return (self.agents + self.talk) * self.steps

    def payoffs(self, question: Question) -> list[float]:
        """Return the agent's catches of earlier months, as its prompt shows them."""
        return [month["caught"][question.agent] for month in question.observation["months"]]

    def play(self, table: Table) -> Play:
        """Play the months."""
        rng, order = table.stream("shares"), table.stream("order")
        stock, talk = self.stock, list[dict[str, Any]]()
        months: list[dict[str, Any]] = []
        for month in table.rounds(self.steps):
            share = sustainable(stock, self.agents) if self.universalisation else None
            shown = {**self._shown(stock, months, talk), "sustainable": share}
            legal = Actions(low=0, high=stock, idle=0)
            wishes = yield [table.ask(agent, CATCH, legal=legal, **shown) for agent in table.agents]
            comes = self._from is not None and month >= self._from
            wanted = [wish.taken for wish in wishes] + [min(self._wanted, stock)] * comes
            got = shares(wanted, stock, self.sharing, rng)
            caught, outsider = got[: self.agents], got[-1] if comes else None
            for wish, tons in zip(wishes, caught, strict=True):
                table.record(wish, utility=tons, caught=tons)
            left = stock - sum(got)
            months.append({"step": month, "stock": stock, "caught": caught, "outsider": outsider, "left": left})
            talk = yield from self._conversation(table, order, self._shown(left, months, []))
            lasts = left >= self.collapse
            after = min(2 * left, self.stock) if lasts else None
            table.write(Stock(step=month, before=stock, caught=sum(caught), outsider=outsider, after=left, next=after))
            if after is None:
                return
            stock = after

    def _shown(self, stock: int, months: Sequence[Mapping[str, Any]], talk: Sequence[Any]) -> dict[str, Any]:
        return {
            "stock": stock,
            "capacity": self.stock,
            "collapse": self.collapse,
            "months": list(months),
            "talk": list(talk),
        }

    def _conversation(self, table: Table, order: Generator, shown: Mapping[str, Any]) -> _Conversation:
        talk: list[dict[str, Any]] = []
        silent = 0
        for agent in islice(cycle(order.permutation(self.agents).tolist()), self.talk):
            (words,) = yield [table.ask(agent, TALK, **{**shown, "talk": list(talk)})]
            table.tell(agent, [other for other in table.agents if other != agent], words.message)
            silent = 0 if words.message is not None else silent + 1
            if words.message is not None:
                talk.append({"agent": agent, "text": words.message})
            if silent == self.agents:
                break
        return talk


def sustainable(stock: int, agents: int) -> int:
    """Return the maximum whole tons that each agent may take so that the stock grows back."""
    return stock // 2 // agents


def shares(wanted: Sequence[int], stock: int, sharing: str, rng: Generator) -> list[int]:
    """Return the tons that each of N agents gets: its wish, or its share if the stock is too small for all wishes.

    Args:
        wanted: wishes in tons, (N,), each from 0 to the stock.
        stock: available tons.
        sharing: one of SHARINGS.
        rng: draws the agents that get the indivisible tons.
    """
    wishes = np.asarray(wanted, dtype=np.int64)
    total = int(wishes.sum())
    if total <= stock:
        gets = wishes
    elif sharing == STOCHASTIC:
        gets = one_by_one(wishes, stock, rng)
    else:
        parts, rest = np.divmod(wishes * stock, total)
        still_wanted = np.where(rest > 0, wishes - parts, 0)
        gets = parts + rng.multivariate_hypergeometric(still_wanted, stock - int(parts.sum()))
    return [int(get) for get in gets]


def one_by_one(wanted: NDArray[np.int64], units: int, rng: Generator) -> NDArray[np.int64]:
    """Return the units that each of N agents gets, if each unit goes to a random agent that still wants some.

    Each agent gets its units after independent, exponentially distributed waiting times. Such times have no memory, so
    each agent that still wants a unit is equally likely to get the next one. Because of this, no loop over the units is
    needed.

    Args:
        wanted: wished units, (N,), in total more than `units`.
        units: available units, at least one.
        rng: draws the gaps.
    """
    times = rng.exponential(size=(len(wanted), int(wanted.max()))).cumsum(axis=1)
    times[np.arange(times.shape[1]) >= wanted[:, None]] = np.inf
    last = np.partition(times, units - 1, axis=None)[units - 1]
    return np.asarray((times <= last).sum(axis=1))


def _outsider(settings: Mapping[str, int] | None) -> tuple[int | None, int]:
    """Return the first month in which an outsider fishes (None: never), and the outsider's wish, tons per month."""
    if settings is None:
        return None, 0
    if not isinstance(settings, Mapping) or set(settings) != {"from", "catch"}:
        raise InputError(f"world.outsider must be null, or a mapping such as {{from: 4, catch: 30}}; got {settings!r}.")
    check_number("world.outsider.from", settings["from"], 1, MOST, whole=True)
    check_number("world.outsider.catch", settings["catch"], 0, MOST, whole=True)
    return settings["from"], settings["catch"]
