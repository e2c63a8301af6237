"""The contract of a world: it states the questions that must be answered now, and takes the answers.

A world never calls a model. The same configuration, seed and answers give the same records, byte for byte.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import ChainMap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias, cast

import msgspec

from foundry import seeding
from foundry.declared import Actions, Declared, keys_of
from foundry.errors import InputError
from foundry.records import Outcome, Record

Observation = Mapping[str, Any]
"""The perception of an agent: plain dicts, lists, strings, numbers and None, by documented keys."""

Asked: TypeAlias = tuple[int, int, str]
"""The step, the agent and the kind of a question, by which it is known."""

STOPPED, LENGTH, ABORTED = "stop", "length", "aborted"
"""The end of a reply's text: complete, at the length limit, or because the backend gave up."""


@dataclass(frozen=True, slots=True)
class Question:
    """One model call as the world sees it.

    Attributes:
        step: 1-based step it belongs to.
        agent: id of the agent that is asked.
        kind: what is asked; a prompt has one template per kind.
        observation: what the agent perceives.
        images: PNG or JPEG bytes that the agent sees, in order.
        secret: what only scripted policies are told, by keys that no template can name.
        options: replies that decide, one for each decision that is legal now; what `scripted/random` draws from. Empty
            where the scenario does not say.
        idle: the reply that does nothing, or None where there is none; what `scripted/stay` says.
        again: how often the agent was asked this before in the same step.
    """

    step: int
    agent: int
    kind: str
    observation: Observation
    images: tuple[bytes, ...] = ()
    secret: Observation | None = None
    options: tuple[str, ...] = ()
    idle: str | None = None
    again: int = 0

    def sampling_seed(self, seed: int) -> int:
        """Return the seed that its reply is sampled with, where a run's calls have this seed."""
        return seeding.sampling_seed(seed, step=self.step, agent=self.agent, kind=self.kind, again=self.again)

    @property
    def asked(self) -> Asked:
        """Its identity."""
        return self.step, self.agent, self.kind

    @property
    def told(self) -> Observation:
        """The observation with the secret, for scripted policies."""
        if self.secret is None:
            return self.observation
        return ChainMap(dict(self.observation), cast("dict[str, Any]", self.secret))


@dataclass(frozen=True, slots=True)
class Reading:
    """The reading of a reply.

    Attributes:
        outcome: what became of the call.
        action: the decision, or None where there is none.
        message: what was said beside it, or instead of one; None for silence.
    """

    outcome: Outcome
    action: str | int | float | None = None
    message: str | None = None


class Answer(msgspec.Struct, frozen=True):
    """The answer of a model.

    Attributes:
        text: the raw reply.
        ending: why the text ended: `stop`, `length` or `aborted`.
        inference_s: seconds the model took when it was asked; a cached answer keeps them.
    """

    text: str
    ending: str = STOPPED
    inference_s: float = 0.0


class Ahead(ABC):
    """Says what can be asked of an episode before its world has come to it.

    A world waits in each round for the slowest answer. Where nothing that is still undecided can touch an agent, its
    later questions are known already, and this puts them: equal to those that the world will give as pending, each of
    them once. The world itself is advanced as ever, round after round, so its records are the same.
    """

    @abstractmethod
    def ready(self) -> Sequence[Question]:
        """Return the questions that can be put now and were not before; one at least, unless answers are awaited."""

    @abstractmethod
    def take(self, asked: Asked, answer: Answer) -> None:
        """Take the answer to one of them."""

    @abstractmethod
    def next_round(self) -> Sequence[Asked]:
        """Return the next round in the order of `pending` and go on to the one after, once it is answered whole."""


class World(ABC):
    """The state of one episode."""

    @property
    @abstractmethod
    def finished(self) -> bool:
        """True if the episode is over; then no question is pending."""

    @property
    @abstractmethod
    def step(self) -> int:
        """Number of completed steps; 0 before the first."""

    def opening(self) -> Sequence[Record]:
        """Return what must be recorded before the first question: facts of the whole episode, if any."""
        return ()

    @abstractmethod
    def pending(self) -> Sequence[Question]:
        """Return the questions that must be answered before the world can advance; no side effects."""

    @abstractmethod
    def advance(self, answers: Sequence[Answer]) -> Sequence[Record]:
        """Take one answer per pending question, in their order, and return what happened."""

    @abstractmethod
    def draw(self) -> bytes:
        """Return the present state as a PNG."""

    def ahead(self) -> Ahead | None:
        """Return what can be asked from here on before the rounds are whole, or None where all wait for all."""
        return None


@dataclass(frozen=True, slots=True)
class Recorded:
    """A recorded episode: its records, whole steps only.

    Attributes:
        seed: the run's seed.
        steps: lines of `steps.jsonl`.
        episode: the line of `episode.jsonl`; empty when the world writes none.
        kept: returns a file of the run's folder by its name in the records, or None when it was not kept.
    """

    seed: int
    steps: bytes
    episode: bytes
    kept: Callable[[str], bytes | None]


class Redrawing(ABC):
    """The pictures of an episode, made again from its records."""

    @property
    def shows_lanes(self) -> bool:
        """Whether the pictures show only agents over time, which the viewer's page draws itself."""
        return False

    @abstractmethod
    def draw(self, step: int) -> bytes:
        """Return the state after `step` (0: the initial one) as the PNG that `World.draw` made then."""

    def told(self, step: int) -> Sequence[str]:
        """Return a film's further captions of a step beside messages; none by default."""
        return ()


class Scenario(ABC):
    """A configured world, shared by all runs of a condition; a world's YAML builds it.

    Attributes:
        name: the world's name in tables and records.
        form: what its records are; names the rooms of code that turn them into arrays, figures and pages.
        records: the classes of the records that its episodes write; no others are taken.
        public_name: the path under which the class promises to stay importable, which its runs' ids hang on; that of
            its definition where it says none.
        kinds: the kinds of question its episodes ask.
        shows_images: whether its questions carry images, which not every model can see.
        grows: whether agents may come into the world after its start; `personas` then has one for each that may.
    """

    form: ClassVar[str]
    kinds: ClassVar[tuple[str, ...]]
    records: ClassVar[tuple[type[Record], ...]]
    public_name: ClassVar[str | None] = None
    shows_images: ClassVar[bool] = False
    grows: bool = False
    name: str

    @abstractmethod
    def start(self, seed: int) -> World:
        """Return a fresh episode for this seed."""

    def redraw(self, recorded: Recorded) -> Redrawing:
        """Return the pictures of an episode that this scenario once started; no model and no world is needed.

        Raises:
            InputError: the scenario does not say how, as by default.
        """
        raise InputError(f"World '{self.name}' does not say how to draw its runs again: give its Scenario a `redraw`.")

    def check_begun(self, episode: bytes) -> None:
        """Check that the files it reads are still those that an episode was begun with; it reads none by default.

        Args:
            episode: the line of `episode.jsonl`.

        Raises:
            InputError: they are not.
        """

    def actions(self) -> Mapping[str, Actions]:
        """Return what can be decided, by the kind of question that decides it; nothing by default."""
        return {}

    def declared(self) -> Declared:
        """Return the declaration of its episodes' records, without building the world."""
        return Declared(form=self.form, actions=dict(self.actions()), streams=keys_of(self.records))

    def personas(self, seed: int) -> Sequence[Mapping[str, str]]:
        """Return the persona of every agent in the run with this seed, by its id; one agent without any by default."""
        return ({},)

    def null_arm(self) -> Mapping[str, Any]:
        """Return the settings of the same world without prompts about the subject of its measures; none by default.

        Runs of that world on the same seeds are the exact null of these measures.
        """
        return {}

    def notes(self) -> Sequence[str]:
        """Return notes on the world before a sweep starts, one line each; none by default."""
        return ()

    def read(self, question: Question, answer: Answer) -> Reading:
        """Return the decision of an answer to one of its questions, as its episodes read it.

        Raises:
            InputError: the scenario does not say, as by default.
        """
        raise InputError(f"World '{self.name}' does not say how one reply is read: give its Scenario a `read`.")

    def strata(self, question: Question) -> Mapping[str, str | bool]:
        """Return the strata of a moment, from which a probe draws evenly; none by default."""
        return {}

    def wordy_answer(self, question: Question, characters: int) -> str:
        """Return an answer of about so many characters that makes later prompts long; filler text by default."""
        return filler(characters)

    @abstractmethod
    def count_calls(self) -> int:
        """Return how many calls a whole episode makes, at most."""


def filler(characters: int) -> str:
    """Return an English text of so many characters that decides nothing."""
    sentence = "There is nothing new to tell, and so it goes on and on. "
    return (sentence * (characters // len(sentence) + 1))[:characters].strip()


def unanswered(answer: Answer) -> Outcome | None:
    """Return the outcome of an answer that holds no text to read, or None when there is text."""
    if answer.ending == ABORTED:
        return Outcome.FAILED
    if answer.text.strip():
        return None
    return Outcome.TRUNCATED if answer.ending == LENGTH else Outcome.EMPTY


def undecided_outcome(answer: Answer) -> Outcome:
    """Return the outcome of a text without a readable decision."""
    return Outcome.TRUNCATED if answer.ending == LENGTH else Outcome.UNREADABLE
