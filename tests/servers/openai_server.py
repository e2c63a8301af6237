"""A real HTTP server that speaks OpenAI's chat completions, with the refusals, limits and habits of several servers."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import msgspec
from aiohttp import web

from local_server import LocalServer
from ollama_cases import grid_answer

Body = dict[str, Any]


@dataclass(frozen=True)
class ChatCase:
    text: str | list[Body] | None = ""
    message: Mapping[str, Any] = field(default_factory=dict)
    finish_reason: str | None = "stop"
    model: str | None = None
    fingerprint: str = "fp_44709d6fcb"
    usage: Mapping[str, object] | None = None
    status: int = 200
    error: Any = None
    headers: Mapping[str, str] = field(default_factory=dict)
    raw: bytes | None = None
    hang: bool = False
    logprobs: list[Body] | None = None
    timings: Mapping[str, Any] | None = None


Answerer = Callable[[Body], str | ChatCase]


def refused(status: int, message: str = "no", *, headers: Mapping[str, str] | None = None, **fields: Any) -> ChatCase:
    """Return a refusal in OpenAI's form; `code`, `type` and `param` by keyword."""
    error = {"message": message, "type": "invalid_request_error", "param": None, "code": None, **fields}
    return ChatCase(status=status, error=error, headers=headers or {})


def limited(**headers: str) -> ChatCase:
    """Return a 429 with these headers, `_` standing for `-`."""
    named = {name.replace("_", "-"): value for name, value in headers.items()}
    return refused(429, "Rate limit reached", type="requests", code="rate_limit_exceeded", headers=named)


def grid_reply(body: Body) -> str:
    """Return a valid reply of a 2D world's agent, decided by the prompt and the seed alone."""
    return grid_answer({"messages": body["messages"], "options": {"seed": body.get("seed")}})


class OpenAIServer(LocalServer):
    """Serves OpenAI's API below `/v1`; keeps the chat `bodies` and the `headers` of all requests as they come."""

    def __init__(
        self,
        answer: Answerer = grid_reply,
        *,
        models: Mapping[str, Mapping[str, Any]] | None = None,
        key: str | None = None,
        lists: bool = True,
        props: Mapping[str, Any] | None = None,
    ) -> None:
        super().__init__()
        self.answer = answer
        self.models = dict(models or {"a": {}, "b": {}, "meta-llama/Llama-3.1-8B": {}})
        self.key = key
        self.lists = lists
        self.props = props
        self.bodies: list[Body] = []
        self.headers: list[dict[str, str]] = []

    @property
    def base_url(self) -> str:
        return f"{self.url}/v1"

    async def _handle(self, request: web.BaseRequest) -> web.StreamResponse:
        self.headers.append({name.lower(): value for name, value in request.headers.items()})
        if self.key is not None and request.headers.get("authorization") != f"Bearer {self.key}":
            given = request.headers.get("authorization", "").removeprefix("Bearer ")
            text = f"Incorrect API key provided: {given}."
            return response_of(refused(401, text, code="invalid_api_key"))
        if (request.method, request.path) == ("GET", "/v1/models") and self.lists:
            rows = [{"id": name, "object": "model", "owned_by": "tests", **row} for name, row in self.models.items()]
            return _json({"object": "list", "data": rows})
        if (request.method, request.path) == ("GET", "/props") and self.props is not None:
            return _json(dict(self.props))
        if (request.method, request.path) == ("POST", "/v1/chat/completions"):
            return await self._chat(msgspec.json.decode(await request.read()))
        return web.Response(status=404, text="404 page not found")

    async def _chat(self, body: Body) -> web.StreamResponse:
        self.bodies.append(body)
        if body["model"] not in self.models:
            text = f"The model `{body['model']}` does not exist"
            return response_of(refused(404, text, code="model_not_found"))
        answer = self.answer(body)
        case = ChatCase(text=answer) if isinstance(answer, str) else answer
        if case.hang:
            await self._stop.wait()
        return response_of(case, body["model"])


def response_of(case: ChatCase, model: str = "") -> web.Response:
    if case.raw is not None:
        return web.Response(body=case.raw, status=case.status, headers=case.headers)
    if case.error is not None:
        return _json({"error": case.error}, case)
    message = {"role": "assistant", "content": case.text, **case.message}
    size = len(case.text or "") // 4 + 1
    told = None if case.logprobs is None else {"content": case.logprobs}
    reply = {
        "id": "chatcmpl-1",
        "object": "chat.completion",
        "created": 1790000000,
        "model": case.model or model,
        "choices": [{"index": 0, "message": message, "logprobs": told, "finish_reason": case.finish_reason}],
        "usage": case.usage or {"prompt_tokens": 11, "completion_tokens": size, "total_tokens": 11 + size},
        "system_fingerprint": case.fingerprint,
        **({} if case.timings is None else {"timings": case.timings}),
    }
    return _json(reply, case)


def _json(value: Body, case: ChatCase | None = None) -> web.Response:
    content = msgspec.json.encode(value)
    status, headers = (case.status, case.headers) if case else (200, {})
    return web.Response(body=content, status=status, headers=dict(headers), content_type="application/json")
