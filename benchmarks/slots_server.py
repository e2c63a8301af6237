"""Simulates a server of models that works on several calls at the same time: `--slots 4 --mean 0.05`.

Its settings give the number of slots, the lengths of replies, the slow-down in a batch, and the limit on calls per
second. Calls without a free slot wait in a queue. `GET /stats` reports the calls so far.
"""

import argparse
import asyncio
import heapq
import itertools
import math
import sys
import threading
import time
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from aiohttp import web

sys.path.append(str(Path(__file__).resolve().parent.parent / "tests" / "servers"))

import ollama_cases
import openai_server
from ollama_server import OllamaServer

TOKENS_PER_REPLY = 100
"""On average."""
BURST = 10
"""Number of calls that may arrive at the same time under a limit on calls per second."""


@dataclass(frozen=True)
class Work:
    """Settings of a simulated server.

    Attributes:
        slots: number of calls that the server works on at the same time.
        mean: mean seconds of work per call, if the call is alone.
        spread: standard deviation of the logarithm of the work per call.
        overhead: seconds per call outside of any slot, as a share of the mean.
        growth: relative slow-down of each call in a full batch, such as 0.5 for about 50 % longer.
        best: size beyond which a batch has a lower throughput; 0 for none.
        per_s: accepted calls per second, other calls get status 429; 0 for any number.
        prompt_s: additional seconds of work for each thousand characters of a prompt.
        load: seconds before the work on the first call begins.
        then_slots: number of slots after a change; 0 for no change.
        then_after: number of calls before the change.
    """

    slots: int
    mean: float
    spread: float
    overhead: float
    growth: float
    best: int
    per_s: float
    prompt_s: float
    load: float
    then_slots: int
    then_after: int

    def slowdown(self, batch: int) -> float:
        """Return the factor by which each of a number of calls takes longer than a call alone."""
        beyond = (batch / self.best) ** 1.5 if self.best else 1.0
        return (1 + self.growth * (batch - 1) / self.slots) * max(1.0, beyond)

    def seconds(self, seed: int, messages: Sequence[Mapping[str, Any]] = ()) -> float:
        """Return the work of a call by its seed and its prompt."""
        normal = np.random.default_rng(seed).standard_normal()
        reading = self.prompt_s * sum(len(message["content"]) for message in messages) / 1000
        return reading + self.mean * math.exp(self.spread * normal - self.spread**2 / 2)


class Engine:
    """Works on calls in slots, in the order of arrival; the number of calls in slots decides their common speed.

    Attributes:
        ends: for the end of every call, the time, the calls in flight, the calls in the queue and the seconds of work.
        refused: number of refused calls.
    """

    def __init__(self, work: Work) -> None:
        self.work = work
        self.ends: list[tuple[float, int, int, float]] = []
        self.refused = 0
        self._in_flight = 0
        self._waiting: deque[tuple[float, asyncio.Future[float]]] = deque()
        self._active: list[tuple[float, int, float, asyncio.Future[float]]] = []
        self._numbers = itertools.count()
        self._done, self._now = 0.0, 0.0
        self._timer: asyncio.TimerHandle | None = None
        self._allowance, self._allowed_at = float(BURST), 0.0
        self._loading = asyncio.Lock()
        self._is_loaded = not work.load

    def lets_in(self) -> bool:
        """Return whether the limit on calls per second allows one more call."""
        if not self.work.per_s:
            return True
        now = time.perf_counter()
        self._allowance = min(BURST, self._allowance + (now - self._allowed_at) * self.work.per_s)
        self._allowed_at = now
        if self._allowance < 1:
            self.refused += 1
            return False
        self._allowance -= 1
        return True

    async def serve(self, seconds: float) -> float:
        """Work on a call that would take the given time alone; return the time that it took."""
        self._in_flight += 1
        try:
            await self._load()
            await asyncio.sleep(self.work.overhead * self.work.mean)
            ended: asyncio.Future[float] = asyncio.get_running_loop().create_future()
            self._waiting.append((seconds, ended))
            self._move_on()
            return await ended
        finally:
            self.ends.append((time.perf_counter(), self._in_flight, len(self._waiting), seconds))
            self._in_flight -= 1

    async def _load(self) -> None:
        """Let all calls wait until the model is loaded."""
        if not self._is_loaded:
            async with self._loading:
                if not self._is_loaded:
                    await asyncio.sleep(self.work.load)
                    self._is_loaded = True

    @property
    def _slots(self) -> int:
        changed = self.work.then_slots and len(self.ends) >= self.work.then_after
        return self.work.then_slots if changed else self.work.slots

    def _move_on(self) -> None:
        """Advance all calls to the present, start waiting calls in free slots, and set the time of the next end."""
        now = time.perf_counter()
        if self._active:
            self._done += (now - self._now) / self.work.slowdown(len(self._active))
        self._now = now
        while self._active and self._active[0][0] <= self._done + 1e-9:
            _, _, began, ended = heapq.heappop(self._active)
            if not ended.done():
                ended.set_result(now - began)
        while self._waiting and len(self._active) < self._slots:
            seconds, ended = self._waiting.popleft()
            heapq.heappush(self._active, (self._done + seconds, next(self._numbers), now, ended))
        if self._timer is not None:
            self._timer.cancel()
        if self._active:
            left_s = (self._active[0][0] - self._done) * self.work.slowdown(len(self._active))
            self._timer = asyncio.get_running_loop().call_later(left_s, self._move_on)


class Watched:
    """Part of a server that reports the calls of its engine."""

    engine: Engine

    def stats(self) -> web.Response:
        """Return the reply to `GET /stats`."""
        return ollama_cases.json_response({"ends": self.engine.ends, "refused": self.engine.refused})


class Ollama(Watched, OllamaServer):
    """Speaks Ollama's API."""

    def __init__(self, engine: Engine) -> None:
        super().__init__(self._answer, keep_bodies=False)
        self.engine = engine

    def _answer(self, body: Mapping[str, Any]) -> ollama_cases.ChatCase:
        return ollama_cases.ChatCase(text=ollama_cases.grid_answer(body))

    async def _handle(self, request: web.BaseRequest) -> web.StreamResponse:
        return self.stats() if request.path == "/stats" else await super()._handle(request)

    async def _play(self, body: dict[str, Any], model: ollama_cases.FakeModel) -> ollama_cases.ChatCase:
        case = await super()._play(body, model)
        if case.status != 200:
            return case
        seconds = self.engine.work.seconds(body["options"]["seed"], body["messages"])
        worked_s = await self.engine.serve(seconds)
        return replace(case, delay_s=worked_s, output_tokens=tokens_in(seconds, self.engine.work))


class OpenAI(Watched, openai_server.OpenAIServer):
    """Speaks OpenAI's API."""

    def __init__(self, engine: Engine) -> None:
        super().__init__(self._answer)
        self.engine = engine

    def _answer(self, body: dict[str, Any]) -> openai_server.ChatCase:
        tokens = tokens_in(self.engine.work.seconds(body["seed"], body["messages"]), self.engine.work)
        usage = {"prompt_tokens": 100, "completion_tokens": tokens, "total_tokens": 100 + tokens}
        return openai_server.ChatCase(text=openai_server.grid_reply(body), usage=usage)

    async def _handle(self, request: web.BaseRequest) -> web.StreamResponse:
        if request.path == "/stats":
            return self.stats()
        if request.method == "POST" and not self.engine.lets_in():
            return openai_server.response_of(openai_server.limited())
        return await super()._handle(request)

    async def _chat(self, body: dict[str, Any]) -> web.StreamResponse:
        await self.engine.serve(self.engine.work.seconds(body["seed"], body["messages"]))
        return await super()._chat(body)


def tokens_in(seconds: float, work: Work) -> int:
    """Return the tokens of a reply that takes the given time if it is alone."""
    return max(1, round(TOKENS_PER_REPLY * seconds / work.mean))


def main() -> None:
    """Serve until interrupted."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--speaks", choices=("ollama", "openai"), default="ollama")
    parser.add_argument("--slots", type=int, required=True)
    parser.add_argument("--mean", type=float, required=True, help="seconds of work per call, on average")
    parser.add_argument("--spread", type=float, default=0.5, help="standard deviation of the logarithm of this work")
    parser.add_argument(
        "--overhead", type=float, default=0.0, help="seconds per call outside of a slot, as a share of the mean"
    )
    parser.add_argument(
        "--growth", type=float, default=0.0, help="relative slow-down of each call in a full batch, such as 0.5"
    )
    parser.add_argument("--best", type=int, default=0, help="size beyond which a batch has a lower throughput")
    parser.add_argument("--per-s", type=float, default=0.0, help="accepted calls per second")
    parser.add_argument(
        "--prompt-s", type=float, default=0.0, help="additional seconds for a thousand characters of a prompt"
    )
    parser.add_argument("--load", type=float, default=0.0, help="seconds before the work on the first call begins")
    parser.add_argument("--then-slots", type=int, default=0, help="slots later on")
    parser.add_argument("--then-after", type=int, default=0, help="number of calls before the change")
    asked = vars(parser.parse_args())
    speaks = asked.pop("speaks")
    engine = Engine(Work(**asked))
    with Ollama(engine) if speaks == "ollama" else OpenAI(engine) as server:
        sys.stdout.write(f"{server.url}\n")
        sys.stdout.flush()
        threading.Event().wait()


if __name__ == "__main__":
    main()
