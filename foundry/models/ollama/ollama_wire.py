"""Makes the bodies of calls to Ollama's `/api/chat`, and reads the replies; opens no connection."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from foundry.errors import RequestError, TransientError
from foundry.models.base import Reply, Request, UnusableReply
from foundry.models.http.logprobs import logprobs_asked, read_logprobs
from foundry.models.http.transport import Origin, aborted_reply, count_in, json_object, schema_of, seconds_in
from foundry.models.ollama.ollama_server import refusal, remote_in
from foundry.texts import without_surrogates
from foundry.worlds.base import LENGTH, STOPPED

DURATIONS = ("total_duration", "load_duration", "prompt_eval_duration", "eval_duration")
BYTES_PER_TOKEN = 4
"""If a prompt has more bytes than this number times the context's tokens, it does not fit, so the server cuts it."""


@dataclass(frozen=True, slots=True)
class ChatSettings:
    """The settings that affect a model's answers, besides the prompt and the seed.

    Attributes:
        think: whether the model thinks first, or how much, such as `low`.
        options: sampling and load-time options, without the seed.
        schemas: JSON Schema of the reply by kind of question, or None for free text.
        logprobs: number of likeliest tokens to report for each token of a reply; None requests none.
    """

    model: str
    think: bool | str
    options: Mapping[str, Any]
    schemas: Mapping[str, Any] | None = None
    logprobs: int | None = None

    @property
    def num_ctx(self) -> int:
        """Size of the context in tokens."""
        return int(self.options["num_ctx"])


def shared_fields(settings: ChatSettings) -> dict[str, Any]:
    """Return the fields that the body of every call has.

    `truncate` is off, since the server would otherwise cut a long prompt silently. `think` is always sent, since models
    that can think do so by default.
    """
    fields = {"model": settings.model, "stream": False, "truncate": False, "think": settings.think}
    return {**fields, **logprobs_asked(settings.logprobs)}


def chat_parameters(settings: ChatSettings) -> dict[str, Any]:
    """Return all fields of a call except messages, seed and keep_alive, with a schema per kind of question."""
    schemas = {} if settings.schemas is None else {"format": dict(settings.schemas)}
    return {**shared_fields(settings), **schemas, "options": dict(settings.options)}


def chat_body(settings: ChatSettings, request: Request, keep_alive: str | float) -> dict[str, Any]:
    """Return the exact body of one call."""
    body = {
        **shared_fields(settings),
        "messages": [_message(m.role, m.content, m.images) for m in request.messages],
        "keep_alive": keep_alive,
        "options": {**settings.options, "seed": request.seed},
    }
    if settings.schemas is not None:
        body["format"] = schema_of(settings.schemas, request.kind)
    return body


def load_body(settings: ChatSettings, keep_alive: str | float) -> dict[str, Any]:
    """Return the body that loads the model with the options of later calls, so that no call loads it again."""
    fields = shared_fields(settings)
    return {**fields, "messages": [], "keep_alive": keep_alive, "options": dict(settings.options)}


def unload_body(model: str) -> dict[str, Any]:
    """Return the body that makes the server free the model's memory."""
    return {"model": model, "messages": [], "stream": False, "keep_alive": 0}


def _message(role: str, content: str, images: tuple[bytes, ...]) -> dict[str, Any]:
    message: dict[str, Any] = {"role": role, "content": without_surrogates(content)}
    if images:
        message["images"] = [base64.b64encode(image).decode() for image in images]
    return message


def read_object(content: bytes, origin: Origin) -> dict[str, Any]:
    """Return the object in the body of a response with status 200."""
    body = json_object(content, origin)
    if "error" in body:
        raise refusal(origin, 500, content)
    return body


def read_reply(content: bytes, request: Request, settings: ChatSettings, origin: Origin, *, latency_s: float) -> Reply:
    """Return the reply in the body of a response with status 200.

    Raises:
        UnusableReply: the model gave up (`done` is not true), or gave no text.
        TransientError: the body is not a reply.
        RequestError: the server cut the prompt to fit the context.
    """
    body = read_object(content, origin)
    if body.get("done") is not True:
        raise UnusableReply(f"{origin}: the model gave up before its reply was done.", aborted_reply(origin))
    message = body.get("message")
    if not isinstance(message, dict):
        raise TransientError(f"{origin}: its reply contains no message.")
    # A <think> block inside the content stays there: the raw reply is recorded, and the world reads it.
    text, thinking = _text(message, "content"), _text(message, "thinking")
    reply = Reply(
        text=text,
        thinking=thinking or None,
        ending=LENGTH if body.get("done_reason") == "length" else STOPPED,
        prompt_tokens=count_in(body, "prompt_eval_count", origin),
        output_tokens=count_in(body, "eval_count", origin),
        timings={**_timings(body, origin), "latency": latency_s},
        host=origin.host,
        server_version=origin.version,
        served_model=_text(body, "model") or None,
        remote=remote_in(body),
        logprobs=read_logprobs(body.get("logprobs")),
    )
    _check_context(reply, request, settings.num_ctx, origin)
    if reply.ending == STOPPED and not text.strip() and not thinking:
        raise UnusableReply(f"{origin}: the reply is empty.", reply)
    return reply


def _text(message: Mapping[str, Any], key: str) -> str:
    value = message.get(key)
    return without_surrogates(value) if isinstance(value, str) else ""


def _timings(body: Mapping[str, Any], origin: Origin) -> dict[str, float]:
    """Return the durations in a reply, seconds, by name; {} if a duration is invalid.

    The wait for a slot, `queue`, is the total minus all other durations.
    """
    durations = seconds_in(body, DURATIONS, origin) if "total_duration" in body else None
    if durations is None:
        return {}
    total, load, prompt, output = durations
    queue = max(0.0, total - load - prompt - output)
    return {"total": total, "load": load, "prompt": prompt, "output": output, "queue": queue}


def _check_context(reply: Reply, request: Request, num_ctx: int, origin: Origin) -> None:
    """Raise an error if the server cut the prompt: the answer would be behaviour in reply to another prompt."""
    if reply.prompt_tokens is None:
        return
    size = sum(len(message.content.encode("utf-8", "replace")) for message in request.messages)
    if reply.prompt_tokens <= num_ctx // 2 + 2 and size > BYTES_PER_TOKEN * num_ctx:
        raise RequestError(
            f"{origin}: silent truncation of a prompt of {size} bytes to {reply.prompt_tokens} tokens. "
            f"Raise model.options.num_ctx ({num_ctx}), or shorten the prompt."
        )
    if reply.prompt_tokens + (reply.output_tokens or 0) > num_ctx:
        raise RequestError(
            f"{origin}: prompt ({reply.prompt_tokens} tokens) and reply ({reply.output_tokens}) overflowed "
            f"the context, so the start of the prompt was lost. Raise model.options.num_ctx ({num_ctx})."
        )
