"""The rules' view of one episode of a world of rounds, and their means to act in it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from numpy.random import Generator

from foundry import seeding
from foundry.declared import Actions
from foundry.errors import FoundryError
from foundry.records import Message, Outcome, Record, RoundStep
from foundry.worlds.base import Answer, Observation, Question, Reading
from foundry.worlds.rounds.decided import Decided
from foundry.worlds.rounds.reading import idle_of, options_of, read_decision, read_talk


@dataclass(frozen=True, eq=False)
class Decision:
    """What one agent answered to one question.

    Attributes:
        step: 1-based round.
        agent: agent id.
        kind: of the question.
        action: what it decided; None where nothing could be read, and for talk.
        taken: what the rules go by: the action, or the idle one where nothing could be read.
        message: what it said, or None.
        outcome: of the call.
    """

    step: int
    agent: int
    kind: str
    action: Decided | None
    taken: Any
    message: str | None
    outcome: Outcome


class Table:
    """One episode, as the rules of its world see it.

    Attributes:
        seed: the run's seed, for what draws its own numbers; the rules draw theirs from `stream`.
        agents: ids of the agents.
        personas: persona of each agent, by its id.
        received: what each agent was told, by its id: `{step, sender, text}`, newest last.
        step: 1-based round that is played; 0 before the first.
    """

    def __init__(
        self,
        seed: int,
        personas: Sequence[Mapping[str, str]],
        actions: Mapping[str, Actions],
        line: type[RoundStep],
    ) -> None:
        """Begin an episode."""
        self.agents = range(len(personas))
        self.personas = personas
        self.received: tuple[list[dict[str, Any]], ...] = tuple([] for _ in personas)
        self.step = 0
        self.seed = seed
        self._actions = actions
        self._line = line
        self._asked: Counter[tuple[int, str]] = Counter()
        self._open: dict[int, Decision] = {}
        self._written: list[Record] = []

    def stream(self, name: str) -> Generator:
        """Return the random generator of this name: the same numbers in every run with this seed."""
        return seeding.stream(self.seed, name)

    def rounds(self, most: int) -> Iterator[int]:
        """Yield the rounds to play; leaving the loop ends the episode early, after the current round."""
        while self.step < most:
            self._close()
            self._asked.clear()
            self.step += 1
            yield self.step

    def ask(
        self,
        agent: int,
        kind: str,
        *,
        legal: Actions | None = None,
        images: tuple[bytes, ...] = (),
        secret: Observation | None = None,
        **observed: Any,
    ) -> Question:
        """Return a question, for the rules to `yield` with others that are asked at the same time.

        Beside what is given here an agent observes `agent`, `agents` (how many there are), `step`, `persona`, and what
        it `received`.

        Args:
            agent: who is asked.
            kind: of the question.
            legal: what can be decided this time, where that is less than the world declares.
            images: PNG or JPEG bytes that the agent sees, in order.
            secret: what only scripted policies are told.
            observed: what the agent perceives and no other.

        Raises:
            FoundryError: no round has begun.
        """
        if not self.step:
            raise FoundryError("questions belong to rounds: ask them in a loop over `table.rounds`")
        actions = legal or self._actions.get(kind)
        common = {
            "step": self.step,
            "agent": agent,
            "agents": len(self.agents),
            "persona": self.personas[agent],
            "received": list(self.received[agent]),
        }
        again = self._asked[agent, kind]
        self._asked[agent, kind] += 1
        return RoundQuestion(
            self.step,
            agent,
            kind,
            common | observed,
            images=images,
            secret=secret,
            options=options_of(actions),
            idle=idle_of(actions),
            again=again,
            legal=actions,
        )

    def record(self, decision: Decision, *, utility: float | None = None, **keys: Any) -> None:
        """Write down a decision with what came of it; those that the rules leave are written as their round ends.

        Args:
            decision: one of this round, once.
            utility: what the agent got from the round with it.
            keys: what the world's class of lines has beside the common keys.

        Raises:
            FoundryError: it was recorded before.
        """
        if self._open.pop(id(decision), None) is None:
            raise FoundryError(f"the {decision.kind} of agent {decision.agent} in round {decision.step} is over")
        self._write(decision, utility=utility, **keys)

    def write(self, record: Record) -> None:
        """Write down anything else that the world declares."""
        self._written.append(record)

    def tell(self, sender: int, recipients: Iterable[int], text: str | None) -> None:
        """Deliver a message at once; nothing where there is none."""
        for recipient in recipients if text is not None else ():
            self.received[recipient].append({"step": self.step, "sender": sender, "text": text})
            self.write(Message(step=self.step, sender=sender, recipient=recipient, text=str(text)))

    def read(self, question: Question, answer: Answer) -> Decision:
        """Return the decision of an answer."""
        found, legal = read_reply(question, answer), _legal(question)
        idle = None if legal is None else legal.idle
        taken = idle if found.action is None else found.action
        decision = Decision(
            question.step, question.agent, question.kind, found.action, taken, found.message, found.outcome
        )
        self._open[id(decision)] = decision
        return decision

    def collect(self, *, ended: bool) -> list[Record]:
        """Return the records since the last call; all records of the round if the episode has ended."""
        if ended:
            self._close()
        written, self._written = self._written, []
        return written

    def _close(self) -> None:
        """Write the decisions that the rules did not."""
        for decision in self._open.values():
            self._write(decision)
        self._open.clear()

    def _write(self, decision: Decision, **keys: Any) -> None:
        line = self._line(
            step=decision.step,
            agent=decision.agent,
            kind=decision.kind,
            action=decision.action,
            outcome=decision.outcome,
            message=decision.message,
            **keys,
        )
        self._written.append(line)


@dataclass(frozen=True, slots=True)
class RoundQuestion(Question):
    """A question with its legal actions, or None if it asks for words alone."""

    legal: Actions | None = None


def read_reply(question: Question, answer: Answer) -> Reading:
    """Return the reading of an answer: a legal decision, or words if there is no decision."""
    legal = _legal(question)
    return read_talk(answer) if legal is None else read_decision(answer, legal, question.kind)


def _legal(question: Question) -> Actions | None:
    return question.legal if isinstance(question, RoundQuestion) else None
