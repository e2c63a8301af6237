"""The naming game: random pairs of agents try to say the same name, so a convention can emerge."""

from collections import abc, deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple, TypeAlias

from numpy.random import Generator

from foundry.declared import Actions, Id
from foundry.errors import InputError, not_found
from foundry.records import Agent, Message, Record, RoundStep
from foundry.worlds.base import Question
from foundry.worlds.rounds.rounds_world import Play, RoundsScenario
from foundry.worlds.rounds.table import Decision, Table
from foundry.worlds.validation import check_number

SAY = "say"
BOTH, SPEAKER = "both", "speaker"
PROTOCOLS = (BOTH, SPEAKER)
CONSENSUS = "consensus"
AGREED = 0.95
"""Minimum share of successful interactions in a round that counts as a consensus."""

_Meetings: TypeAlias = abc.Generator[Sequence[Question], list[Decision], int]


class Naming(RoundStep, frozen=True, kw_only=True):
    """A decision of the naming game: the name that an agent said.

    Attributes:
        number: 1-based number of the interaction.
    """

    number: Id


class Meeting(Record, frozen=True, kw_only=True):
    """One interaction (`meetings.jsonl`).

    Attributes:
        step: 1-based round.
        number: 1-based number, in the order of the drawn pairs.
        first: agent id; the speaker if only one speaks.
        second: agent id.
        first_name: name that the first agent said, or null for an unreadable reply.
        second_name: name that the second agent said; null for an unreadable reply or if only the first speaks.
        equal: whether the interaction succeeded.
    """

    stream: ClassVar[str] = "meetings"

    step: int
    number: Id
    first: Id
    second: Id
    first_name: str | None
    second_name: str | None
    equal: bool


class _Pair(NamedTuple):
    """Two agents that meet; `number` is the 1-based number of their interaction."""

    number: int
    first: int
    second: int


@dataclass
class _Namer:
    """The state of an agent.

    Attributes:
        memory: the agent's latest interactions, each with `own`, `other` and `points`, newest last.
        known: the names that the agent knows, with the protocol `speaker`.
        says: the name that the agent always says; None for an agent that is asked.
    """

    memory: deque[dict[str, Any]]
    known: list[str]
    says: str | None
    met: int
    points: float


class NamingGame(RoundsScenario):
    """Pairs of agents that try to say the same name.

    Description:
        A round is N/2 interactions (rounded down) of random pairs, all pairs equally likely. So an agent may meet
        several others in a round, or none. With the protocol `both`, both agents say a name at once, and succeed if the
        names are equal. With `speaker`, the first agent says a name that it knows. If the other agent knows this name,
        they succeed, and both forget all other names; else the other agent learns the name. An agent that knows no name
        says any of `names`; if `names` is null, it invents one. After a success both get `equal` points, after a
        failure `different`. The share `committed` of agents, drawn at random, always says `committed_name`, learns
        nothing, and gets no questions. With `established`, all agents begin with a memory full of that name.

    Observation:
        `names`, each time in a random order. `memory`: the latest interactions, at most as many as the setting
        `memory`, each with `own` and `other` name (null if none was said) and `points`. `met`: number of interactions
        so far; `points`: their sum; both include the memory of an `established` name. `equal`, `different` and
        `protocol`.

    Questions:
        `say`. Interactions without a common agent are asked at once, unless one must wait for an earlier interaction
        of its agents.

    Actions:
        One of `names`. An unreadable reply names nothing, and the interaction fails.

    Termination:
        After `steps` rounds; with `until: consensus`, after the first round with 95 % of successful interactions.

    Source:
        A. F. Ashery, L. M. Aiello and A. Baronchelli, Science Advances 11 (2025) eadu9368, arXiv 2410.08948; `speaker`:
        A. Baronchelli et al., J. Stat. Mech. (2006) P06014, arXiv physics/0509075 and physics/0512045. The first source
        measures consensus over the last N/2 interactions, this world over each round. The numbers from the first source
        (24 agents, 10 names, points, memory) were not checked in its text.
    """

    kinds: ClassVar[tuple[str, ...]] = (SAY,)
    records: ClassVar[tuple[type[Record], ...]] = (Naming, Message, Agent, Meeting)

    def __init__(
        self,
        *,
        names: Sequence[str] | None,
        protocol: str,
        memory: int,
        equal: float,
        different: float,
        established: str | None,
        committed: float,
        committed_name: str | None,
        until: str | None,
        **settings: Any,
    ) -> None:
        super().__init__(**settings)
        if protocol not in PROTOCOLS:
            raise not_found("world.protocol", str(protocol), PROTOCOLS)
        if until not in (None, CONSENSUS):
            raise not_found("world.until", str(until), (CONSENSUS, "null"))
        check_number("world.agents", self.agents, 2, whole=True)
        check_number("world.memory", memory, 0, whole=True)
        self.names = _checked_names(names, protocol, self.agents)
        self.coined = names is None
        self.speaks = protocol == SPEAKER
        self.memory, self.equal, self.different = memory, equal, different
        self.established = _among("established", established, self.names)
        self.committed = _committed(committed, self.agents)
        self.committed_name = _among("committed_name", committed_name, self.names)
        if self.committed and committed_name is None:
            raise InputError(f"world.committed={committed} needs world.committed_name=<one of world.names>.")
        self.until = until

    def actions(self) -> dict[str, Actions]:
        """Return the possible names; there is no idle action."""
        return {SAY: Actions(labels=self.names)}

    def count_calls(self) -> int:
        """Return the maximum number of calls in an episode."""
        return self.agents // 2 * (1 if self.speaks else 2) * self.steps

    def payoffs(self, question: Question) -> list[float]:
        """Return the points that the agent got in each interaction that it remembers, as its prompt shows them."""
        return [met["points"] for met in question.observation["memory"]]

    def play(self, table: Table) -> Play:
        """Play the rounds."""
        rng, episode = table.stream("pairs"), _Episode(self, table)
        for step in table.rounds(self.steps):
            pairs = _drawn_pairs(self.agents, rng)
            before = (step - 1) * len(pairs)
            successes = 0
            for wave in waves(pairs):
                successes += yield from episode.meet([_Pair(before + place + 1, *pairs[place]) for place in wave])
            if self.until and successes >= AGREED * len(pairs):
                return


class _Episode:
    def __init__(self, rules: NamingGame, table: Table) -> None:
        committed = set(table.stream("committed").permutation(rules.agents)[: rules.committed].tolist())
        self._rules, self._table = rules, table
        self._shown = table.stream("order of names")
        self._every = Actions(labels=rules.names)
        self._namers = [self._namer(rules.committed_name if agent in committed else None) for agent in table.agents]

    def meet(self, pairs: Sequence[_Pair]) -> _Meetings:
        """Let pairs without a common agent meet; return the number of successful meetings."""
        speakers = [agent for pair in pairs for agent in (pair.first, pair.second)[: 1 if self._rules.speaks else 2]]
        names = {agent: self._namers[agent].says for agent in speakers}
        agents = [agent for agent in speakers if names[agent] is None]
        decisions = (yield [self._question(agent) for agent in agents]) if agents else []
        names |= {decision.agent: decision.taken for decision in decisions}
        met = [self._met(pair, names.get(pair.first), names.get(pair.second)) for pair in pairs]
        by_agent = {agent: meeting for meeting in met for agent in (meeting.first, meeting.second)}
        for decision in decisions:
            meeting = by_agent[decision.agent]
            self._table.record(decision, utility=self._points(meeting), number=meeting.number)
        for meeting in met:
            self._table.write(meeting)
        return sum(meeting.equal for meeting in met)

    def _namer(self, says: str | None) -> _Namer:
        rules, name = self._rules, self._rules.established
        past = {"own": name, "other": name, "points": rules.equal}
        memory = [dict(past) for _ in range(rules.memory)] if name is not None else []
        known = [name_said for name_said in (says or name,) if name_said is not None]
        points = len(memory) * float(rules.equal)
        return _Namer(deque(memory, maxlen=rules.memory), known, says, len(memory), points)

    def _question(self, agent: int) -> Question:
        rules, namer = self._rules, self._namers[agent]
        legal = self._every
        if rules.speaks and (namer.known or rules.coined):
            legal = Actions(labels=tuple(namer.known) or (rules.names[agent],))
        order = self._shown.permutation(len(legal.labels)).tolist()
        return self._table.ask(
            agent,
            SAY,
            legal=legal,
            names=[legal.labels[place] for place in order],
            memory=list(namer.memory),
            met=namer.met,
            points=namer.points,
            equal=rules.equal,
            different=rules.different,
            protocol=SPEAKER if rules.speaks else BOTH,
        )

    def _met(self, pair: _Pair, mine: str | None, other: str | None) -> Meeting:
        """Return the record of an interaction, and add the interaction to the memory of both agents."""
        first, second = self._namers[pair.first], self._namers[pair.second]
        equal = mine is not None and (mine in second.known if self._rules.speaks else mine == other)
        if self._rules.speaks and mine is not None:
            _learn(first, second, mine, equal=equal)
        meeting = Meeting(
            step=self._table.step,
            number=pair.number,
            first=pair.first,
            second=pair.second,
            first_name=mine,
            second_name=other,
            equal=equal,
        )
        points = self._points(meeting)
        for namer, own, heard in ((first, mine, other), (second, other, mine)):
            namer.memory.append({"own": own, "other": heard, "points": points})
            namer.met += 1
            namer.points += points
        return meeting

    def _points(self, meeting: Meeting) -> float:
        return self._rules.equal if meeting.equal else self._rules.different


def _learn(speaker: _Namer, hearer: _Namer, name: str, *, equal: bool) -> None:
    """After a success, let both agents forget all other names; after a failure, let the hearer learn this name."""
    if name not in speaker.known:
        speaker.known.append(name)
    if equal:
        speaker.known, hearer.known = [name], [name]
    elif hearer.says is None:
        hearer.known.append(name)


def _drawn_pairs(agents: int, rng: Generator) -> list[tuple[int, int]]:
    """Return the agents // 2 ordered pairs of a round; all pairs of two different agents are equally likely."""
    first = rng.integers(agents, size=agents // 2)
    second = (first + 1 + rng.integers(agents - 1, size=agents // 2)) % agents
    return list(zip(first.tolist(), second.tolist(), strict=True))


def waves(pairs: Sequence[tuple[int, int]]) -> list[list[int]]:
    """Return lists with the indices of pairs; the pairs of one list share no agent, so they can meet at once.

    Each pair is in the first list after its agents' earlier pairs, so every agent meets others in the given order.
    """
    free: dict[int, int] = {}
    places: list[list[int]] = []
    for place, (first, second) in enumerate(pairs):
        wave = max(free.get(first, 0), free.get(second, 0))
        if wave == len(places):
            places.append([])
        places[wave].append(place)
        free[first] = free[second] = wave + 1
    return places


def _checked_names(names: Sequence[str] | None, protocol: str, agents: int) -> tuple[str, ...]:
    if names is None and protocol == SPEAKER:
        return tuple(f"n{agent}" for agent in range(agents))
    known = isinstance(names, Sequence) and not isinstance(names, str) and all(isinstance(name, str) for name in names)
    if names is None or not known or len(set(names)) < len(names) or not names:
        raise InputError(
            f"world.names must be a list of different texts, or null with world.protocol=speaker; got {names!r}."
        )
    return tuple(names)


def _among(key: str, name: str | None, names: Sequence[str]) -> str | None:
    if name is not None and name not in names:
        raise not_found(f"world.{key}", str(name), names)
    return name


def _committed(share: float, agents: int) -> int:
    check_number("world.committed", share, 0, 1)
    number = round(share * agents)
    if number == agents:
        raise InputError(f"world.committed={share} commits all agents, so nobody is asked. Give a smaller share.")
    return number
