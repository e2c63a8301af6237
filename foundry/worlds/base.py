"""The interface of a world: it states the questions that need an answer now, and takes the answers.

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
"""The data that an agent perceives: a dict of plain dicts, lists, texts, numbers and None."""

QuestionKey: TypeAlias = tuple[int, int, str]
"""Step, agent and kind, which identify a question."""

STOPPED, LENGTH, ABORTED = "stop", "length", "aborted"
"""Causes of a reply's end: it is complete, it reached the limit of its length, or the backend gave up."""


class Computed(Mapping[str, Any]):
    """A mapping that computes a value only when it is read, since few policies read secret data."""

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
    """A question of a world to an agent, which one model call answers.

    Attributes:
        step: 1-based step.
        kind: kind of question; a prompt has one template per kind.
        observation: data that the agent perceives.
        images: PNG or JPEG bytes that the agent sees, in order.
        secret: data that only scripted policies get; templates cannot read these data.
        options: a reply for each legal decision; `scripted/random` draws from them. Without such replies, the list is
            empty.
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
        """Return the seed for sampling the model's reply to this question, computed from the run's sampling seed."""
        return seeding.sampling_seed(seed, step=self.step, agent=self.agent, kind=self.kind, again=self.again)

    @property
    def asked(self) -> QuestionKey:
        """Step, agent and kind, which identify the question."""
        return self.step, self.agent, self.kind

    @property
    def told(self) -> Observation:
        """The observation together with the data that only scripted policies get (`secret`), in one mapping."""
        if self.secret is None:
            return self.observation
        return ChainMap(dict(self.observation), cast("dict[str, Any]", self.secret))


@dataclass(frozen=True, slots=True)
class Reading:
    """The outcome of a reply, and the decision or message that the world reads in the reply.

    Attributes:
        action: the decision, or None.
        message: message to other agents, with or instead of a decision; None for silence.
    """

    outcome: Outcome
    action: str | int | float | None = None
    message: str | None = None


class Answer(msgspec.Struct, frozen=True):
    """A model's reply, as the world gets it.

    Attributes:
        ending: why the text ended: `stop`, `length` or `aborted`.
        inference_s: seconds of inference; a cached answer keeps them.
        logprobs: tokens of the reply with their log-probabilities; empty if the server gave none, or if the model
            thought separately.
    """

    text: str
    ending: str = STOPPED
    inference_s: float = 0.0
    logprobs: tuple[TokenLogprobs, ...] = ()

    def __hash__(self) -> int:
        """Return a hash of all fields but `logprobs`, which has no hash; an answer is the key of cached readings."""
        return hash((self.text, self.ending, self.inference_s))


class Ahead(ABC):
    """Finds the questions of later steps of an episode whose content is already known, so that they can be asked early.

    A world waits in each round for the slowest answer. But if no missing answer can affect an agent, the agent's next
    questions are already known. This class returns each of these known questions once; the world later states the same
    questions. The world itself still advances round by round, so its records do not change.
    """

    @abstractmethod
    def ready(self) -> Sequence[Question]:
        """Return the new questions that can be asked now; at least one question if no answer is awaited."""

    @abstractmethod
    def take(self, asked: QuestionKey, answer: Answer) -> None:
        """Take the answer to a question that was asked early."""

    @abstractmethod
    def next_round(self) -> Sequence[QuestionKey]:
        """Return the questions of the next round, in the world's order; none while an answer is missing."""


class World(ABC):
    """One episode of a world, with its present state."""

    @property
    @abstractmethod
    def finished(self) -> bool:
        """True if the episode is over, so that no question is pending."""

    @property
    @abstractmethod
    def step(self) -> int:
        """Number of completed steps; 0 before the first."""

    def opening(self) -> Sequence[Record]:
        """Return the records written before the first question: facts about the whole episode, if there are any."""
        return ()

    @abstractmethod
    def pending(self) -> Sequence[Question]:
        """Return the questions that must be answered before the world can advance. This changes nothing."""

    @abstractmethod
    def advance(self, answers: Sequence[Answer]) -> Sequence[Record]:
        """Take one answer per pending question, in the order of the questions; return the new records."""

    @abstractmethod
    def draw(self) -> bytes:
        """Return the present state as a PNG."""

    def ahead(self) -> Ahead | None:
        """Return an object that finds questions that can be asked early; None if agents always wait for each other."""
        return None


@dataclass(frozen=True, slots=True)
class Recorded:
    """The records of an episode; their last step is complete.

    Attributes:
        steps: lines of `steps.jsonl`.
        episode: the line of `episode.jsonl`; empty if the world writes none.
        kept: function that returns the content of a file that the records name, or None if it was deleted.
    """

    seed: int
    steps: bytes
    episode: bytes
    kept: Callable[[str], bytes | None]


class Redrawing(ABC):
    """Draws the pictures of an episode from its records."""

    @property
    def shows_lanes(self) -> bool:
        """True if pictures only show decisions by agent and round; the viewer then draws them itself."""
        return False

    @abstractmethod
    def draw(self, step: int) -> bytes:
        """Return the same PNG as the running world after `step` steps (0: the initial state)."""

    def told(self, step: int) -> Sequence[str]:
        """Return the captions that a film shows for a step, besides the messages; none by default."""
        return ()


class Scenario(ABC):
    """A configured world, shared by all runs of a condition and built from the world's YAML.

    Attributes:
        name: the world's name in tables and records.
        form: name of the form of the world's records; by this name, foundry finds the code that turns records into
            arrays and pages.
        records: classes of the records that the world's episodes write; records of other classes are rejected.
        public_name: path from which the class will always be importable; run ids depend on it. None means the path of
            the class's definition.
        shows_images: whether the world's questions contain images, which not every model can see.
        grows: whether agents may join after the start; `personas` then includes agents that may join.
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
        """Check that the files of the world have not changed since the episode began; by default, a world has no files.

        Args:
            episode: the line of `episode.jsonl`.

        Raises:
            InputError: a file differs.
        """

    def actions(self) -> Mapping[str, Actions]:
        """Return the possible decisions for each kind of question; none by default."""
        return {}

    def declared(self) -> Declared:
        """Return the form, actions and files of this world's records, which `sweep.yaml` states."""
        return Declared(form=self.form, actions=dict(self.actions()), streams=keys_of(self.records))

    def personas(self, seed: int) -> Sequence[Mapping[str, str]]:
        """Return the persona of each agent in the run with this seed; by default one empty persona, for agent 0."""
        return ({},)

    def null_arm(self) -> Mapping[str, Any]:
        """Return settings that remove the studied cause, such as fires, from prompts; none by default.

        Runs with these settings and the same seeds give the exact null distribution of the world's measures.
        """
        return {}

    def notes(self) -> Sequence[str]:
        """Return notes that a user sees before a sweep starts, one line each; none by default."""
        return ()

    def read(self, question: Question, answer: Answer) -> Reading:
        """Read the decision from an answer to a question, by the same rules as in an episode.

        Raises:
            InputError: the scenario cannot read single replies, which is the default.
        """
        raise InputError(f"World '{self.name}' cannot read a single reply: add a method `read` to its Scenario.")

    def strata(self, question: Question) -> Mapping[str, str | bool]:
        """Return properties of a moment by name; a probe takes about equally many moments for each value."""
        return {}

    def wordy_answer(self, question: Question, characters: int) -> str:
        """Return an answer of about this length, to estimate the longest prompts; by default, text without meaning."""
        return filler(characters)

    @abstractmethod
    def count_calls(self) -> int:
        """Return the maximum number of calls in an episode."""


def filler(characters: int) -> str:
    """Return an English text of this length that contains no decision."""
    sentence = "There is nothing new to tell, and so it goes on and on. "
    return (sentence * (characters // len(sentence) + 1))[:characters].strip()


def unanswered(answer: Answer) -> Outcome | None:
    """Return the outcome of an answer without text, or None if there is text to read."""
    if answer.ending == ABORTED:
        return Outcome.FAILED
    if answer.text.strip():
        return None
    return Outcome.TRUNCATED if answer.ending == LENGTH else Outcome.EMPTY


def undecided_outcome(answer: Answer) -> Outcome:
    """Return the outcome of an answer without a readable decision: truncated if the text was cut, else unreadable."""
    return Outcome.TRUNCATED if answer.ending == LENGTH else Outcome.UNREADABLE
