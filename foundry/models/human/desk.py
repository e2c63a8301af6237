"""Keeps questions to people until they are answered; a page shows one question at a time."""

import asyncio
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any

from foundry.errors import InputError, Interrupted
from foundry.models.base import ChatMessage, Reply, Request

Schema = Mapping[str, Any]


@dataclass(frozen=True)
class WaitingQuestion:
    """A question that waits for a person's answer."""

    number: int
    person: str
    messages: tuple[ChatMessage, ...]
    schema: Schema | None


@dataclass(frozen=True)
class Standing:
    """The state of a desk (the queue of questions to a person), as the page shows it.

    Attributes:
        version: number that grows with every change.
        agreed: whether the person agreed to be asked; before that, no question is shown.
        question: the question that is shown, or None.
        waiting: number of questions without an answer, including the one that is shown.
    """

    version: int
    agreed: bool
    question: WaitingQuestion | None
    answered: int
    waiting: int
    over: bool


@dataclass(frozen=True)
class _Waiting:
    asked: WaitingQuestion
    order: tuple[Any, ...]
    reply: asyncio.Future[Reply]
    loop: asyncio.AbstractEventLoop


class Desk:
    """Shows questions one at a time, and takes one answer to each. Any thread may hand in an answer."""

    def __init__(self, *, blind: bool = False, clock: Callable[[], float] = time.perf_counter) -> None:
        """Make a desk without questions.

        Args:
            blind: whether questions come in an order that hides where they come from, not by step and agent.
            clock: function that returns the time, seconds.
        """
        self._blind = blind
        self._clock = clock
        self._changed = threading.Condition()
        self._waiting: dict[int, _Waiting] = {}
        self._now: _Waiting | None = None
        self._since = 0.0
        self._numbers = self._answered = 0
        self._version = 1
        self._agreed = self._over = False

    async def ask(self, person: str, request: Request, schema: Schema | None) -> Reply:
        """Put a question to a person, and wait without limit for the answer."""
        with self._changed:
            if self._over:
                raise Interrupted
            self._numbers += 1
            entry = WaitingQuestion(self._numbers, person, request.messages, schema)
            loop = asyncio.get_running_loop()
            place = (request.key,) if self._blind else (request.step, request.agent, entry.number)
            waiting = self._waiting[entry.number] = _Waiting(entry, (person, *place), loop.create_future(), loop)
            self._note()
        try:
            return await waiting.reply
        finally:
            with self._changed:
                self._forget(waiting)

    def agree(self) -> None:
        """Begin to show questions."""
        with self._changed:
            self._agreed = True
            self._note()

    def answer(self, number: int, text: str) -> None:
        """Take the answer to the question that is shown."""
        if not text.strip():
            raise InputError("The answer is empty: choose an option, or write something.")
        with self._changed:
            waiting = self._now
            if waiting is None or waiting.asked.number != number:
                raise InputError(f"Question {number} is no longer asked: it has an answer, or the sitting ended.")
            seconds = self._clock() - self._since
            self._forget(waiting)
            self._answered += 1
            reply = Reply(text=text, timings={"total": seconds, "latency": seconds})
            waiting.loop.call_soon_threadsafe(_settle, waiting.reply, reply)

    def leave(self) -> None:
        """Stop asking people: questions without an answer stay open, and no further question is shown."""
        with self._changed:
            self._over = True
            for waiting in list(self._waiting.values()):
                self._forget(waiting)
                waiting.loop.call_soon_threadsafe(_settle, waiting.reply, Interrupted())
            self._note()

    def standing(self, after: int = 0, patience_s: float = 0.0) -> Standing:
        """Return the desk's state once its version is above `after`, or after `patience_s` seconds at the latest."""
        with self._changed:
            self._changed.wait_for(lambda: self._version > after, patience_s)
            question = None if self._now is None else self._now.asked
            return Standing(self._version, self._agreed, question, self._answered, len(self._waiting), self._over)

    def _forget(self, waiting: _Waiting) -> None:
        if self._waiting.pop(waiting.asked.number, None) is not None:
            if self._now is waiting:
                self._now = None
            self._note()

    def _note(self) -> None:
        """Show the next question if none is shown, and notify everyone who waits for a change."""
        if self._now is None and self._waiting and self._agreed:
            self._now = min(self._waiting.values(), key=lambda waiting: waiting.order)
            self._since = self._clock()
        self._version += 1
        self._changed.notify_all()


def _settle(future: asyncio.Future[Reply], outcome: Reply | Interrupted) -> None:
    if future.done():
        return
    if isinstance(outcome, Reply):
        future.set_result(outcome)
    else:
        future.set_exception(outcome)


DESK: ContextVar[Desk | None] = ContextVar("DESK", default=None)
"""The desk of the present command, if this command asks people on a page; else None."""


@contextmanager
def seated(desk: Desk) -> Iterator[None]:
    """Make this the desk of the command (see `DESK`) while the block runs."""
    before = DESK.set(desk)
    try:
        yield
    finally:
        DESK.reset(before)
        desk.leave()
