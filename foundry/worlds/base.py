"""The contract of a world: it states the questions that must be answered now, and takes the answers.

A world never calls a model. The same configuration, seed and answers give the same records, byte for byte.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from foundry.records import Outcome, Record

Observation = Mapping[str, Any]
"""What an agent perceives: plain dicts, lists, strings, numbers and None, by documented keys."""

STOPPED, LENGTH, ABORTED = "stop", "length", "aborted"
"""Why a reply's text ended: by itself, at the length limit, or because the backend gave up."""


@dataclass(frozen=True, slots=True)
class Question:
    """One model call as the world sees it.

    Attributes:
        step: 1-based step it belongs to.
        agent: id of the agent that is asked.
        kind: what is asked; a prompt has one template per kind.
        observation: what the agent perceives.
        images: PNG or JPEG bytes that the agent sees, in order.
    """

    step: int
    agent: int
    kind: str
    observation: Observation
    images: tuple[bytes, ...] = ()


@dataclass(frozen=True, slots=True)
class Answer:
    """What the model said.

    Attributes:
        text: the raw reply.
        ending: why the text ended: `stop`, `length` or `aborted`.
        inference_s: seconds the model took when it was asked; a cached answer keeps them.
    """

    text: str
    ending: str = STOPPED
    inference_s: float = 0.0


class World(ABC):
    """The state of one episode."""

    @property
    @abstractmethod
    def finished(self) -> bool:
        """Whether the episode is over; then nothing is pending."""

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


class Scenario(ABC):
    """A configured world, shared by all runs of a condition; what a world's YAML instantiates.

    Attributes:
        name: the world's name in tables and records.
        kinds: the kinds of question its episodes ask.
        shows_images: whether its questions carry images, which not every model can see.
    """

    kinds: ClassVar[tuple[str, ...]]
    shows_images: ClassVar[bool] = False
    name: str

    @abstractmethod
    def start(self, seed: int) -> World:
        """Return a fresh episode for this seed."""

    @abstractmethod
    def count_calls(self) -> int:
        """Return how many calls a whole episode makes, at most."""


def unanswered(answer: Answer) -> Outcome | None:
    """Return the outcome of an answer that holds no text to read, or None when there is text."""
    if answer.ending == ABORTED:
        return Outcome.FAILED
    if answer.text.strip():
        return None
    return Outcome.TRUNCATED if answer.ending == LENGTH else Outcome.EMPTY


def undecided_outcome(answer: Answer) -> Outcome:
    """Return the outcome of a text in which no decision could be read."""
    return Outcome.TRUNCATED if answer.ending == LENGTH else Outcome.UNREADABLE
