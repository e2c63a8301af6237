"""A server whose weights are replaced while a sweep runs, and put back; other weights give other answers."""

import itertools
from collections import Counter
from collections.abc import Callable

from ollama_cases import Body, ChatCase, body_key, grid_answer
from ollama_server import OllamaServer

MODEL = "qwen3:4b"
FIRST, SECOND = "d4" * 32, "ff" * 32


class Replaced:
    """Answers as its weights do; those are replaced at one call, which the new ones answer."""

    def __init__(
        self,
        at: int,
        *,
        written: bool = False,
        held_from: int | None = None,
        then: Callable[[int], None] = lambda call: None,
    ) -> None:
        """Replace the weights at the call of this number, from 1; `written` tells of it in the list's dates too."""
        self.server: OllamaServer
        self.held_from = held_from
        self.then = then
        self.answered: Counter[bytes] = Counter()
        self.second: list[Body] = []
        self._at = at
        self._written = written
        self._calls = itertools.count(1)
        self._days = itertools.count(2)

    def __call__(self, body: Body) -> str | ChatCase:
        number = next(self._calls)
        if self.held_from is not None and number >= self.held_from:
            return ChatCase(hang=True)
        if number == self._at:
            self.put(SECOND)
        if number >= self._at:
            self.then(number)
        if self.server.models[MODEL].digest == FIRST:
            self.answered[body_key(body)] += 1
            return grid_answer(body)
        self.second.append(body)
        return grid_answer({**body, "options": {"seed": -1}})

    def put(self, digest: str) -> None:
        model = self.server.models[MODEL]
        model.digest = digest
        if self._written:
            model.modified_at = f"2026-09-{next(self._days):02}T12:00:00Z"

    def put_back(self) -> None:
        self.put(FIRST)

    def serve(self) -> OllamaServer:
        self.server = OllamaServer(self)
        return self.server
