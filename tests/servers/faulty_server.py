"""An Ollama server that fails in every way one was seen to, and keeps count of what it was paid for."""

import hashlib
import threading
from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

from ollama_cases import (
    ABORTED,
    ABORTED_500,
    CUT,
    DROPPED,
    EMPTY,
    ERROR_WITH_200,
    HANGING,
    ONLY_THINKING,
    RUNNER_DIED,
    Body,
    ChatCase,
    body_key,
    busy,
    grid_answer,
    refused,
)
from ollama_server import OllamaServer

TRANSIENT: Mapping[str, ChatCase] = {
    "503": busy(),
    "503 with Retry-After": busy("0.01"),
    "429": refused(429, "too many requests"),
    "408": refused(408, "request timeout"),
    "499": refused(499, "request canceled"),
    "502": refused(502, "bad gateway"),
    "504": refused(504, "gateway timeout"),
    "500, the runner died": RUNNER_DIED,
    "200 with an error": ERROR_WITH_200,
    "dropped": DROPPED,
    "cut body": CUT,
    "dropped in the middle": ChatCase(text="This connection never ends well.", cut=True, drop=True),
    "not JSON": ChatCase(raw=b"<html>Bad Gateway</html>"),
    "JSON, no object": ChatCase(raw=b"[1, 2]"),
    "no body": ChatCase(raw=b""),
    "slower than the time-out": ChatCase(text="too late", delay_s=600.0),
    "hangs": HANGING,
}
"""Faults that another try cures."""
DECIDED: Mapping[str, ChatCase] = {
    "empty": EMPTY,
    "only thinking": ONLY_THINKING,
    "aborted, 200": ABORTED,
    "aborted, 500": ABORTED_500,
    "cut by the length limit": ChatCase(text='{"action": "mo', done_reason="length"),
}
"""Faults that are an outcome of the decision: the same request meets them whenever it is made."""
REFUSAL = refused(400, "this prompt is refused")
"""Ends its run, whenever it is made."""


@dataclass(frozen=True)
class Shares:
    decided: float = 0.0
    refused: float = 0.0


@dataclass
class Books:
    """What came and went, by `body_key`."""

    arrived: Counter[bytes] = field(default_factory=Counter)
    open: Counter[bytes] = field(default_factory=Counter)
    paid: Counter[bytes] = field(default_factory=Counter)
    faults: Counter[str] = field(default_factory=Counter)


class FaultyServer(OllamaServer):
    """Answers as `grid_answer` does, with faults."""

    def __init__(self, shares: Shares, *, each_once: bool = False) -> None:
        super().__init__(self._answer, latency_s=0.002)
        self.shares = shares
        self.books = Books()
        self._lock = threading.Lock()
        self._due = list(TRANSIENT) if each_once else []

    def seen(self) -> Books:
        with self._lock:
            return Books(*map(Counter, vars(self.books).values()))

    @property
    def requests(self) -> dict[bytes, Body]:
        return {body_key(body): body for body in self.bodies}

    def _answer(self, body: Body) -> ChatCase:
        key = body_key(body)
        with self._lock:
            fault = self._fault(key)
            if fault is not None:
                self.books.faults[fault] += 1
                return {**TRANSIENT, **DECIDED, "refused": REFUSAL}[fault]
        return ChatCase(text=grid_answer(body))

    def _fault(self, key: bytes) -> str | None:
        if self._due:
            return self._due.pop(0)
        fate = _share(key, b"fate")
        if fate < self.shares.refused:
            return "refused"
        if fate < self.shares.refused + self.shares.decided:
            return list(DECIDED)[int(_share(key, b"outcome") * len(DECIDED))]
        return None

    @contextmanager
    def _counted(self, body: Body) -> Iterator[None]:
        key = body_key(body)
        with self._lock:
            self.books.arrived[key] += 1
            self.books.open[key] += 1
        try:
            with super()._counted(body):
                yield
        finally:
            with self._lock:
                self.books.open[key] -= 1

    def _note(self, body: Body, case: ChatCase) -> None:
        super()._note(body, case)
        broken = case.cut or case.drop or case.raw is not None or case.error is not None or not case.done
        if case.status == 200 and case.text and not broken:
            with self._lock:
                self.books.paid[body_key(body)] += 1


def _share(*parts: bytes | int) -> float:
    digest = hashlib.blake2b(repr(parts).encode(), digest_size=8).digest()
    return int.from_bytes(digest, "little") / 2**64
