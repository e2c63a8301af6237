"""A real HTTP server that speaks Ollama's API and can play everything a real one was seen to do.

In a test: `with OllamaServer() as server: ... server.url`. In a process of its own, for benchmarks:
`python tests/servers/ollama_server.py --port 0 --latency 0.05`, which prints its URL.
"""

import argparse
import asyncio
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import msgspec
from aiohttp import web

from local_server import LocalServer
from ollama_cases import (
    DROPPED,
    Answerer,
    Body,
    ChatCase,
    Counts,
    FakeModel,
    body_key,
    chat_reply,
    default_models,
    grid_answer,
    json_response,
    load_key,
    overflow_of,
    refusal_of,
    send,
)

OnChat = Callable[[int, Body], None]


class OllamaServer(LocalServer):
    """Serves Ollama's API on 127.0.0.1 from a thread of its own.

    Attributes:
        bodies: the chat bodies in the order of their arrival; `headers` are those of all requests, in lower case.
        loads: the bodies of calls that only load or unload.
        answered: how often each distinct chat body, by `body_key`, was answered with 200.
    """

    def __init__(
        self,
        answer: Answerer = grid_answer,
        *,
        models: list[FakeModel] | None = None,
        latency_s: float = 0.0,
        holds_loads: bool = False,
        version: str = "0.32.15",
        on_chat: OnChat | None = None,
        keep_bodies: bool = True,
        port: int = 0,
    ) -> None:
        super().__init__(port)
        self.answer = answer
        self.models = {model.name: model for model in models or default_models()}
        self.registry = {"gemma3:4b"}
        self.offline = False
        self.latency_s = latency_s
        self.holds_loads = holds_loads
        self.version = version
        self.on_chat = on_chat
        self.counts = Counts()
        self._keep_bodies = keep_bodies
        self.bodies: list[Body] = []
        self.loads: list[Body] = []
        self.headers: list[dict[str, str]] = []
        self.answered: Counter[bytes] = Counter()
        self._loaded: dict[str, tuple[Any, ...]] = {}
        self._loading = asyncio.Lock()
        self._let_go = asyncio.Event()
        self._freed = asyncio.Event()
        self._routes = {
            ("GET", "/"): self._home,
            ("HEAD", "/"): self._home,
            ("GET", "/api/version"): self._version,
            ("GET", "/api/tags"): self._tags,
            ("GET", "/api/ps"): self._ps,
            ("POST", "/api/show"): self._show,
            ("POST", "/api/chat"): self._chat,
            ("POST", "/api/pull"): self._pull,
        }

    @property
    def loaded(self) -> tuple[str, ...]:
        return tuple(self._loaded)

    def drop_hanging(self) -> None:
        self._loop.call_soon_threadsafe(self._let_go.set)

    def free(self) -> None:
        """Let the calls and loads go on that are held, and hold no more."""
        self._loop.call_soon_threadsafe(self._freed.set)

    def _end(self) -> None:
        self._let_go.set()
        self._freed.set()
        super()._end()

    async def _handle(self, request: web.BaseRequest) -> web.StreamResponse:
        if self._keep_bodies:
            self.headers.append({name.lower(): value for name, value in request.headers.items()})
        route = self._routes.get((request.method, request.path))
        if route is None:
            return web.Response(status=404, text="404 page not found")
        return await route(request)

    async def _home(self, request: web.BaseRequest) -> web.Response:
        return web.Response(text="Ollama is running")

    async def _version(self, request: web.BaseRequest) -> web.Response:
        return json_response({"version": self.version})

    async def _tags(self, request: web.BaseRequest) -> web.Response:
        return json_response({"models": [model.row for model in self.models.values()]})

    async def _ps(self, request: web.BaseRequest) -> web.Response:
        rows = [self.models[name].row | {"context_length": key[0]} for name, key in self._loaded.items()]
        return json_response({"models": rows})

    async def _show(self, request: web.BaseRequest) -> web.Response:
        model = self._find(msgspec.json.decode(await request.read())["model"])
        if model is None:
            return json_response({"error": "model not found"}, status=404)
        return json_response(model.shown)

    async def _pull(self, request: web.BaseRequest) -> web.StreamResponse:
        name = msgspec.json.decode(await request.read())["model"]
        if self.offline:  # as a real one says it: in the stream, after status 200
            lookup = "lookup registry.ollama.ai: no such host"
            said = f'pull model manifest: Get "https://registry.ollama.ai/v2/library/{name}": dial tcp: {lookup}'
            said_so = [{"status": "pulling manifest"}, {"error": said}]
            return web.Response(body=b"\n".join(map(msgspec.json.encode, said_so)), content_type="application/x-ndjson")
        if name not in self.registry:
            return json_response({"error": "pull model manifest: file does not exist"}, status=500)
        self.models[name] = FakeModel(name)
        sizes = [{"total": 10, "completed": part} for part in (0, 5, 10)]
        lines = [{"status": "pulling manifest"}, *({"status": "pulling a1a1", **size} for size in sizes)]
        content = b"\n".join(msgspec.json.encode(line) for line in [*lines, {"status": "success"}])
        return web.Response(body=content, content_type="application/x-ndjson")

    def _find(self, name: str) -> FakeModel | None:
        return self.models.get(name if ":" in name else f"{name}:latest")

    async def _chat(self, request: web.BaseRequest) -> web.StreamResponse:
        arrived = time.perf_counter()
        try:
            body = msgspec.json.decode(await request.read())
        except msgspec.DecodeError as error:
            return json_response({"error": str(error)}, status=400)
        model = self._find(body.get("model", ""))
        if model is None:
            return json_response({"error": f"model '{body.get('model')}' not found"}, status=404)
        if not body.get("messages"):
            return await self._load_only(body, model)
        with self._counted(body):
            case = await self._play(body, model)
            if case.hang:
                await self._let_go.wait()
                case = case if self._stop.is_set() else DROPPED
            await asyncio.sleep(0)  # lets the loop see that a caller was killed, whose answer then goes nowhere
            if request.transport is not None and not request.transport.is_closing():
                self._note(body, case)
            elapsed_s, worked_s = time.perf_counter() - arrived, self.latency_s + case.delay_s
            return await send(request, case, chat_reply(body, case, elapsed_s, worked_s))

    async def _load_only(self, body: Body, model: FakeModel) -> web.Response:
        self.loads.append(body)
        reason = "unload" if body.get("keep_alive") == 0 else "load"
        if reason == "unload":
            self.counts.unloads += 1
            self._loaded.pop(model.name, None)
        else:
            await self._ensure_loaded(body, model)
        empty = {"role": "assistant", "content": ""}
        return json_response({"model": body["model"], "message": empty, "done": True, "done_reason": reason})

    @contextmanager
    def _counted(self, body: Body) -> Iterator[None]:
        self.counts.chats += 1
        self.counts.in_flight += 1
        self.counts.most_in_flight = max(self.counts.most_in_flight, self.counts.in_flight)
        if self._keep_bodies:
            self.bodies.append(body)
        try:
            if self.on_chat is not None:
                self.on_chat(self.counts.chats, body)
            yield
        finally:
            self.counts.in_flight -= 1

    def _note(self, body: Body, case: ChatCase) -> None:
        if self._keep_bodies and case.status == 200 and not case.drop:
            self.answered[body_key(body)] += 1

    async def _play(self, body: Body, model: FakeModel) -> ChatCase:
        refusal = refusal_of(body, model)
        if refusal is not None:
            return refusal
        answer = self.answer(body)
        case = ChatCase(text=answer) if isinstance(answer, str) else answer
        if case.status != 200:
            await asyncio.sleep(case.delay_s)
            return case
        await self._ensure_loaded(body, model)
        if case.held:
            await self._freed.wait()
        await asyncio.sleep(self.latency_s + case.delay_s)
        overflow = overflow_of(body) if case.prompt_tokens is None else None
        return overflow or case

    async def _ensure_loaded(self, body: Body, model: FakeModel) -> None:
        """Load the model unless it is, with the same options."""
        key = load_key(body)
        async with self._loading:
            if self._loaded.get(model.name) != key:
                if self.holds_loads:
                    await self._freed.wait()
                self._loaded[model.name] = key
                self.counts.loads += 1


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--port", type=int, default=0)
    parser.add_argument("--latency", type=float, default=0.0, help="seconds of work per call")
    asked = parser.parse_args()
    with OllamaServer(port=asked.port, latency_s=asked.latency, keep_bodies=False) as server:
        sys.stdout.write(f"{server.url}\n")
        sys.stdout.flush()
        threading.Event().wait()


if __name__ == "__main__":
    main()
