"""An Ollama server that fails in every way one was seen to, from a seed, and keeps count of what it was paid for."""

import asyncio
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
MOST_IN_A_ROW = 3


@dataclass(frozen=True)
class Shares:
    """Shares of the calls: that fail for once, that have a fault for an outcome, that are refused."""

    transient: float = 0.0
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

    def __init__(self, shares: Shares, *, seed: int = 0, each_once: bool = False, latency_s: float = 0.002) -> None:
        super().__init__(self._answer, latency_s=latency_s)
        self.shares = shares
        self.books = Books()
        self._lock = threading.Lock()
        self._seed = seed
        self._due = list(TRANSIENT) if each_once else []
        self._digests = {name: model.digest for name, model in self.models.items()}

    def start_again(self, digest: str | None = None) -> None:
        """Leave and come back at the same address, with other weights if a digest is given, which answer otherwise."""
        self.__exit__()
        self._port = int(self.url.rpartition(":")[2])
        self._ready.clear()
        self._loading, self._let_go = asyncio.Lock(), asyncio.Event()
        self._loaded.clear()
        for name, model in self.models.items():
            model.digest = digest or self._digests[name]
        self.__enter__()

    def seen(self) -> Books:
        """Return the books as they are now."""
        with self._lock:
            return Books(*map(Counter, vars(self.books).values()))

    @property
    def requests(self) -> dict[bytes, Body]:
        """Every distinct body, by `body_key`."""
        return {body_key(body): body for body in self.bodies}

    def _answer(self, body: Body) -> ChatCase:
        key = body_key(body)
        with self._lock:
            fault = self._fault(body, key)
            if fault is not None:
                self.books.faults[fault] += 1
                return {**TRANSIENT, **DECIDED, "refused": REFUSAL}[fault]
        changed = self.models[self._find(body["model"]).name].digest not in self._digests.values()  # type: ignore[union-attr]
        return ChatCase(text="{}" if changed else grid_answer(body))

    def _fault(self, body: Body, key: bytes) -> str | None:
        tries = self.books.arrived[key]
        if self._due:
            return self._due.pop(0)
        if tries <= MOST_IN_A_ROW and _share(key, self._seed, tries, b"whether") < self.shares.transient:
            return _pick(TRANSIENT, _share(key, self._seed, tries, b"which"))
        fate = _share(key, b"fate")
        if fate < self.shares.refused:
            return "refused"
        if fate < self.shares.refused + self.shares.decided:
            return _pick(DECIDED, _share(key, b"outcome"))
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


def _pick(kinds: Mapping[str, ChatCase], share: float) -> str:
    return list(kinds)[int(share * len(kinds))]


def _share(*parts: bytes | int) -> float:
    """Return a number in 0..1 that the parts decide."""
    digest = hashlib.blake2b(repr(parts).encode(), digest_size=8).digest()
    return int.from_bytes(digest, "little") / 2**64
