"""The object with which the rules of a game ask questions, record decisions and deliver messages."""

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
    """An agent's decision on a question.

    Attributes:
        step: 1-based round.
        action: the decision; None for an unreadable reply and for talk.
        taken: the action that the rules apply: the decision, or the idle action after an unreadable reply.
        message: the agent's message, or None.
    """

    step: int
    agent: int
    kind: str
    action: Decided | None
    taken: Any
    message: str | None
    outcome: Outcome


class Table:
    """The object through which the rules of a game run one episode.

    Attributes:
        seed: the run's seed, for code that draws its own numbers; the rules use `stream`.
        personas: persona of each agent, by its id.
        received: messages to each agent, by its id: `{step, sender, text}`, newest last.
        step: 1-based round in progress; 0 before the first.
    """

    def __init__(
        self,
        seed: int,
        personas: Sequence[Mapping[str, str]],
        actions: Mapping[str, Actions],
        line: type[RoundStep],
    ) -> None:
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
        """Return the random generator with this name; its numbers depend only on the run's seed."""
        return seeding.stream(self.seed, name)

    def rounds(self, most: int) -> Iterator[int]:
        """Yield the number of each round, from 1 to `most`; if you leave the loop, the current round is the last."""
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
        """Return a question; to ask it, the rules must yield it in a list of questions.

        The agent also observes `agent`, `agents` (their number), `step`, `persona`, and the messages that it
        `received`.

        Args:
            agent: id of the agent that answers.
            kind: kind of question.
            legal: legal decisions, if fewer than the world declares.
            images: PNG or JPEG bytes that the agent sees, in order.
            secret: data for scripted policies only.
            observed: further keys of the agent's observation.

        Raises:
            FoundryError: no round has begun.
        """
        if not self.step:
            raise FoundryError("no round has begun: ask questions in a loop over `table.rounds`")
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
        """Record a decision and its result. If the rules do not call this, the decision is recorded without a result.

        Args:
            decision: a decision of this round.
            utility: the agent's utility from the decision in this round.
            keys: values of the keys that the world's line class adds to the common ones.

        Raises:
            FoundryError: the decision is already recorded.
        """
        if self._open.pop(id(decision), None) is None:
            raise FoundryError(
                f"the {decision.kind} of agent {decision.agent} in round {decision.step} is already recorded: record "
                "each decision once, in its round"
            )
        self._write(decision, utility=utility, **keys)

    def write(self, record: Record) -> None:
        """Write a record that is neither a decision nor a message; the world must have declared its class."""
        self._written.append(record)

    def tell(self, sender: int, recipients: Iterable[int], text: str | None) -> None:
        """Deliver a message at once; None means no message."""
        for recipient in recipients if text is not None else ():
            self.received[recipient].append({"step": self.step, "sender": sender, "text": text})
            self.write(Message(step=self.step, sender=sender, recipient=recipient, text=str(text)))

    def read(self, question: Question, answer: Answer) -> Decision:
        """Return the decision in an answer."""
        reading, legal = read_reply(question, answer), _legal(question)
        idle = None if legal is None else legal.idle
        taken = idle if reading.action is None else reading.action
        decision = Decision(
            question.step, question.agent, question.kind, reading.action, taken, reading.message, reading.outcome
        )
        self._open[id(decision)] = decision
        return decision

    def collect(self, *, ended: bool) -> list[Record]:
        """Return the records written since the last call; once the episode has ended, also unrecorded decisions."""
        if ended:
            self._close()
        written, self._written = self._written, []
        return written

    def _close(self) -> None:
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
    """A question with its legal actions; `legal` is None if the question asks for a message instead of a decision."""

    legal: Actions | None = None


def read_reply(question: Question, answer: Answer) -> Reading:
    """Read a legal decision from an answer, or a message if the question asks for a message."""
    legal = _legal(question)
    return read_talk(answer) if legal is None else read_decision(answer, legal, question.kind)


def _legal(question: Question) -> Actions | None:
    return question.legal if isinstance(question, RoundQuestion) else None
