"""The interface of a world: a world states the questions that need an answer now, and takes the answers.

A world never calls a model. The same configuration, seed and answers give the same records, byte for byte.
"""

from abc import ABC, abstractmethod
from collections import ChainMap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, TypeAlias, cast

import msgspec

from foundry import seeding
from foundry.canary import TokenLogprobs
from foundry.declared import Actions, Declared, keys_of
from foundry.errors import InputError
from foundry.records import Outcome, Record

Observation = Mapping[str, Any]
"""The perception of an agent: plain dicts, lists, strings, numbers and None, by documented keys."""

Asked: TypeAlias = tuple[int, int, str]
"""Identity of a question: step, agent and kind."""

STOPPED, LENGTH, ABORTED = "stop", "length", "aborted"
"""Reasons why a reply's text ended: it is complete, it reached the length limit, or the backend gave up."""


class Computed(Mapping[str, Any]):
    """A mapping that computes each value when it is read, for `Question.secret`: few policies read it."""

    def __init__(self, functions: Mapping[str, Callable[[], Any]]) -> None:
        self._functions = functions

    def __getitem__(self, key: str) -> Any:
        return self._functions[key]()

    def __iter__(self) -> Iterator[str]:
        return iter(self._functions)

    def __len__(self) -> int:
        return len(self._functions)


@dataclass(frozen=True, slots=True)
class Question:
    """One model call as the world sees it.

    Attributes:
        step: 1-based step.
        kind: kind of question; a prompt has one template per kind.
        observation: perception of the agent.
        images: PNG or JPEG bytes that the agent sees, in order.
        secret: data for scripted policies only; templates do not have these keys.
        options: a reply for each legal decision; `scripted/random` draws from them. Empty if the scenario lists none.
        idle: the reply that does nothing, which `scripted/stay` gives; None if there is none.
        again: number of earlier questions of this kind to the agent in this step.
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
        """Return the sampling seed of the reply in a run with this seed for its calls."""
        return seeding.sampling_seed(seed, step=self.step, agent=self.agent, kind=self.kind, again=self.again)

    @property
    def asked(self) -> Asked:
        """Step, agent and kind, which identify the question."""
        return self.step, self.agent, self.kind

    @property
    def told(self) -> Observation:
        """The observation together with the secret, for scripted policies."""
        if self.secret is None:
            return self.observation
        return ChainMap(dict(self.observation), cast("dict[str, Any]", self.secret))


@dataclass(frozen=True, slots=True)
class Reading:
    """The reading of a reply.

    Attributes:
        action: the decision, or None.
        message: words with the decision, or instead of it; None for silence.
    """

    outcome: Outcome
    action: str | int | float | None = None
    message: str | None = None


class Answer(msgspec.Struct, frozen=True):
    """The answer of a model.

    Attributes:
        ending: why the text ended: `stop`, `length` or `aborted`.
        inference_s: seconds of inference; a cached answer keeps them.
        logprobs: tokens of the reply with their log-probabilities; empty if the server gave none, or after separate
            thinking.
    """

    text: str
    ending: str = STOPPED
    inference_s: float = 0.0
    logprobs: tuple[TokenLogprobs, ...] = ()

    def __hash__(self) -> int:
        """Return a hash of all but the tokens, which have no hash; the reading of replies is cached by answer."""
        return hash((self.text, self.ending, self.inference_s))


class Ahead(ABC):
    """Announces questions of an episode before its world reaches them.

    A world waits in each round for the slowest answer. But if no open answer can affect an agent, its later questions
    are already known. This class returns these questions, each once and equal to the world's later pending question.
    The world itself still advances round by round, so its records do not change.
    """

    @abstractmethod
    def ready(self) -> Sequence[Question]:
        """Return the questions that can be asked now, each once; at least one, unless answers are still awaited."""

    @abstractmethod
    def take(self, asked: Asked, answer: Answer) -> None:
        """Take the answer to a question."""

    @abstractmethod
    def next_round(self) -> Sequence[Asked]:
        """Return the next round in the order of `pending`; if it is fully answered, move on to the round after it."""


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
        """Return the records before the first question: facts about the whole episode, if any."""
        return ()

    @abstractmethod
    def pending(self) -> Sequence[Question]:
        """Return the questions that must be answered before the world can advance; no side effects."""

    @abstractmethod
    def advance(self, answers: Sequence[Answer]) -> Sequence[Record]:
        """Take one answer per pending question, in the order of the questions; return the new records."""

    @abstractmethod
    def draw(self) -> bytes:
        """Return the present state as a PNG."""

    def ahead(self) -> Ahead | None:
        """Return the questions that can be asked ahead of their round, or None if every agent waits for all others."""
        return None


@dataclass(frozen=True, slots=True)
class Recorded:
    """A recorded episode: its records, as whole steps.

    Attributes:
        steps: lines of `steps.jsonl`.
        episode: the line of `episode.jsonl`; empty if the world writes none.
        kept: function that returns a file of the run's folder by its name in the records, or None if it was deleted.
    """

    seed: int
    steps: bytes
    episode: bytes
    kept: Callable[[str], bytes | None]


class Redrawing(ABC):
    """The pictures of an episode, drawn from its records."""

    @property
    def shows_lanes(self) -> bool:
        """Whether the pictures show only agents over time; the viewer's page draws such pictures itself."""
        return False

    @abstractmethod
    def draw(self, step: int) -> bytes:
        """Return the state after `step` (0: the initial state) as the PNG that `World.draw` made then."""

    def told(self, step: int) -> Sequence[str]:
        """Return further captions of a step in a film, in addition to messages; none by default."""
        return ()


class Scenario(ABC):
    """A configured world, shared by all runs of a condition and built from the world's YAML.

    Attributes:
        name: the world's name in tables and records.
        form: name of the form of its records; each layer's code for this form turns them into arrays and pages.
        records: classes of the records that its episodes write; records of other classes are rejected.
        public_name: path from which the class will always be importable; run ids depend on it. By default, the path of
            its definition.
        shows_images: whether its questions contain images, which not every model can see.
        grows: whether agents may join after the start; `personas` then has one for each agent that may join.
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
        """Return the pictures of a recorded episode of this scenario, without a model or a running world.

        Raises:
            InputError: the scenario cannot redraw, which is the default.
        """
        raise InputError(f"World '{self.name}' cannot redraw its runs: add a method `redraw` to its Scenario.")

    def check_begun(self, episode: bytes) -> None:
        """Check that its input files have not changed since the episode began; by default there are none.

        Args:
            episode: the line of `episode.jsonl`.

        Raises:
            InputError: a file differs.
        """

    def actions(self) -> Mapping[str, Actions]:
        """Return the possible decisions by kind of question; none by default."""
        return {}

    def declared(self) -> Declared:
        """Return the declaration of its episodes' records, without building the world."""
        return Declared(form=self.form, actions=dict(self.actions()), streams=keys_of(self.records))

    def personas(self, seed: int) -> Sequence[Mapping[str, str]]:
        """Return the persona of every agent in the run with this seed, by id; by default, one agent without any."""
        return ({},)

    def null_arm(self) -> Mapping[str, Any]:
        """Return settings of this world that remove the subject of its measures from prompts; none by default.

        Runs with these settings on the same seeds give the exact null distribution of the measures.
        """
        return {}

    def notes(self) -> Sequence[str]:
        """Return notes on the world before a sweep starts, one line each; none by default."""
        return ()

    def read(self, question: Question, answer: Answer) -> Reading:
        """Return the decision in an answer to a question, as episodes of this scenario read it.

        Raises:
            InputError: the scenario cannot read single replies, which is the default.
        """
        raise InputError(f"World '{self.name}' cannot read a single reply: add a method `read` to its Scenario.")

    def strata(self, question: Question) -> Mapping[str, str | bool]:
        """Return the strata of a moment, from which a probe samples evenly; None by default."""
        return {}

    def wordy_answer(self, question: Question, characters: int) -> str:
        """Return an answer of about the given length that makes later prompts long; filler text by default."""
        return filler(characters)

    @abstractmethod
    def count_calls(self) -> int:
        """Return the maximum number of calls in an episode."""


def filler(characters: int) -> str:
    """Return an English text of the given length without a decision."""
    sentence = "There is nothing new to tell, and so it goes on and on. "
    return (sentence * (characters // len(sentence) + 1))[:characters].strip()


def unanswered(answer: Answer) -> Outcome | None:
    """Return the outcome of an answer without any text to read, or None if there is text."""
    if answer.ending == ABORTED:
        return Outcome.FAILED
    if answer.text.strip():
        return None
    return Outcome.TRUNCATED if answer.ending == LENGTH else Outcome.EMPTY


def undecided_outcome(answer: Answer) -> Outcome:
    """Return the outcome of a text without a readable decision."""
    return Outcome.TRUNCATED if answer.ending == LENGTH else Outcome.UNREADABLE
