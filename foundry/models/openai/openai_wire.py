"""Makes the bodies of calls to OpenAI's chat completions, and reads replies and errors; opens no connection."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from foundry.canary import TokenLogprobs
from foundry.errors import BackendError, RequestError, ServerError, TransientError
from foundry.models.base import ChatMessage, Reply, Request, UnusableReply
from foundry.models.http.logprobs import logprobs_asked, read_logprobs
from foundry.models.http.transport import (
    Origin,
    aborted_reply,
    count_in,
    decoded,
    error_text,
    json_object,
    model_failure,
    name_in,
    schema_of,
    seconds_in,
)
from foundry.texts import without_surrogates
from foundry.worlds.base import LENGTH, STOPPED

BUSY = frozenset({429, 502, 503, 529})
TRANSIENT = frozenset({408, 409, 425, 499, 504})
HOPELESS: Mapping[int, str] = {
    401: "Put the key into {key_env}, or name its variable with model.server.api_key_env.",
    402: "The account has no money left.",
    403: "The key or the address may not use this model.",
    404: "Check the model's name, and the end of model.server.base_url, which is often /v1.",
    405: "Check the end of model.server.base_url, which is often /v1.",
}
"""HTTP statuses of errors that a repeated call would meet again, each with advice to the user."""
FATAL: Mapping[str, str] = {
    "insufficient_quota": "The account has no money left.",
    "billing_hard_limit_reached": "The account has no money left.",
    "billing_not_active": "The account has no money left.",
    "invalid_api_key": "Put the key into {key_env}, or name its variable with model.server.api_key_env.",
    "model_not_found": "Check the model's name on the server.",
    "unsupported_parameter": "Leave {param} out: model.options.{param}=null",
    "unsupported_value": "Change {param}, or leave it out: model.options.{param}=null",
    "unknown_parameter": "Remove {param} from model.options and model.extra.",
}
"""Codes and types of errors that a repeated call would get again; each has advice to the user."""
TOO_LONG = frozenset({"context_length_exceeded", "exceed_context_size_error"})
BLIND = ("image input is not supported", "does not support image", "is not a multimodal model")
"""Texts of errors that reject images; llama.cpp sends one of them with status 500."""
ADVICE = "It would be refused again: check the options, the schema and the images against the model."
PNG = b"\x89PNG"
ENDINGS: Mapping[object, str] = {
    **dict.fromkeys(("stop", "eos", "eos_token", "stop_sequence", "tool_calls", "function_call"), STOPPED),
    **dict.fromkeys(("length", "max_tokens", "model_length"), LENGTH),
}
"""Finish reasons after which the text is usable; after any other, such as `content_filter`, the text is not used."""


def refusal(
    origin: Origin, status: int, content: bytes, wait_s: float | None = None, *, key_env: str | None = None
) -> BackendError:
    """Return the error for a response, by its status and body."""
    text = error_text(content)
    line = f"{origin}: {status} {text}".rstrip(".") + "."
    fields = {"key_env": key_env or "an environment variable", "param": _field(content, "param") or "the parameter"}
    codes = {_field(content, "code"), _field(content, "type")}
    way_on = next((FATAL[code] for code in sorted(codes) if code in FATAL), None) or HOPELESS.get(status)
    if way_on is not None:
        return ServerError(line, advice=way_on.format(**fields))
    if codes & TOO_LONG:
        advice = "The prompt does not fit: give the server a longer context, or shorten the prompt."
        return RequestError(line, advice=advice)
    if any(part in text for part in BLIND):
        return RequestError(line, advice="The model has no vision: set model.vision=false.")
    if status >= 500 and (failure := model_failure(origin, line)) is not None:
        return failure
    return _by_status(line, status, wait_s)


def _by_status(line: str, status: int, wait_s: float | None) -> BackendError:
    if status in BUSY:
        return TransientError(line, busy=True, retry_after_s=wait_s)
    if status in TRANSIENT or status >= 500:
        return TransientError(line, retry_after_s=wait_s)
    if status >= 400:
        return RequestError(line, advice=ADVICE)
    return ServerError(line, advice="This is not an answer of an OpenAI API; check model.server.base_url.")


def _field(content: bytes, name: str) -> str:
    body = decoded(content)
    error = body.get("error", body) if isinstance(body, dict) else None
    value = error.get(name) if isinstance(error, dict) else None
    return str(value) if isinstance(value, str | int) else ""


@dataclass(frozen=True, slots=True)
class ChatSettings:
    """The settings that affect a model's answers, besides the prompt and the seed.

    Attributes:
        options: options of the protocol and of the server, without the seed.
        revision: text by which the user identifies the weights; it is never sent.
        logprobs: number of likeliest tokens to report for each token of a reply; None requests none.
    """

    model: str
    options: Mapping[str, Any]
    seed_field: str | None = "seed"
    image_detail: str | None = None
    schemas: Mapping[str, Any] | None = None
    schema_strict: bool = False
    context_length: int | None = None
    revision: str | None = None
    logprobs: int | None = None

    @property
    def sent(self) -> dict[str, Any]:
        """The fields that the body of every call has besides model, messages and seed."""
        return {"stream": False, **self.options, **logprobs_asked(self.logprobs)}


def chat_parameters(settings: ChatSettings) -> dict[str, Any]:
    """Return all fields of a call except messages and seed, with a response format per kind of question."""
    parameters: dict[str, Any] = {"model": settings.model, **settings.sent}
    if settings.schemas is not None:
        parameters["response_format"] = {kind: _response_format(settings, kind) for kind in settings.schemas}
    unsent = {"seed_field": settings.seed_field, "image_detail": settings.image_detail, "revision": settings.revision}
    return {**parameters, **{key: value for key, value in unsent.items() if value is not None}}


def chat_body(settings: ChatSettings, request: Request) -> dict[str, Any]:
    """Return the exact body of one call."""
    body: dict[str, Any] = {
        "model": settings.model,
        "messages": [_message(message, settings.image_detail) for message in request.messages],
        **settings.sent,
    }
    if settings.seed_field is not None:
        body[settings.seed_field] = request.seed
    if settings.schemas is not None:
        body["response_format"] = _response_format(settings, request.kind)
    return body


def _response_format(settings: ChatSettings, kind: str) -> dict[str, Any]:
    assert settings.schemas is not None
    named = {"name": kind, "strict": settings.schema_strict, "schema": schema_of(settings.schemas, kind)}
    return {"type": "json_schema", "json_schema": named}


def _message(message: ChatMessage, detail: str | None) -> dict[str, Any]:
    """Return a message with its images before the text, as in the training of models."""
    text = without_surrogates(message.content)
    if not message.images:
        return {"role": message.role, "content": text}
    parts = [_image_part(image, detail) for image in message.images]
    return {"role": message.role, "content": [*parts, {"type": "text", "text": text}]}


def _image_part(image: bytes, detail: str | None) -> dict[str, Any]:
    kind = "png" if image.startswith(PNG) else "jpeg"
    url = {"url": f"data:image/{kind};base64,{base64.b64encode(image).decode()}"}
    return {"type": "image_url", "image_url": url if detail is None else {**url, "detail": detail}}


def read_reply(content: bytes, request: Request, settings: ChatSettings, origin: Origin, *, latency_s: float) -> Reply:
    """Return the reply in the body of a response with status 200.

    Raises:
        UnusableReply: the server gave up on this call, or the model returned no text.
        TransientError: the body is not a reply.
        RequestError: prompt and reply do not fit the context, so something was cut.
    """
    body = json_object(content, origin)
    if body.get("error"):
        raise _error_with_200(body["error"], content, origin)
    choice = _choice(body, origin)
    message = choice["message"]
    finish_reason = name_in(choice.get("finish_reason"))
    ending = ENDINGS.get(finish_reason)
    if ending is None:
        reason = f"{origin}: the reply ended with the reason '{finish_reason}'."
        raise UnusableReply(reason, aborted_reply(origin))
    reply = Reply(
        text=_text(message.get("content")) or _text(message.get("refusal")),
        thinking=_text(message.get("reasoning_content")) or _text(message.get("reasoning")) or None,
        ending=ending,
        prompt_tokens=_count(body, "prompt_tokens", origin),
        output_tokens=_count(body, "completion_tokens", origin),
        timings={**_timings(body, origin, latency_s), "latency": latency_s},
        host=origin.host,
        server_version=name_in(body.get("system_fingerprint")),
        served_model=name_in(body.get("model")),
        cached_tokens=_cached_tokens(body, origin),
        logprobs=_logprobs(choice),
    )
    _check_context(reply, settings.context_length, origin)
    if reply.ending == STOPPED and not reply.text.strip() and not reply.thinking:
        raise UnusableReply(f"{origin}: the reply is empty.", reply)
    return reply


def _error_with_200(error: Any, content: bytes, origin: Origin) -> BackendError:
    """Return the error in a response with status 200, or None; gateways send errors with this status."""
    code = error.get("code") if isinstance(error, dict) else None
    status = code if isinstance(code, int) and 400 <= code < 600 else 500
    return refusal(origin, status, content)


def _choice(body: Mapping[str, Any], origin: Origin) -> Mapping[str, Any]:
    choices = body.get("choices")
    choice = choices[0] if isinstance(choices, list) and choices else None
    if not isinstance(choice, dict) or not isinstance(choice.get("message"), dict):
        raise TransientError(f"{origin}: its reply contains no message.")
    return choice


def _text(value: Any) -> str:
    """Return the text of a message's content: a string, or a list whose parts of other kinds than text are left out."""
    if isinstance(value, list):
        parts = (part.get("text") for part in value if isinstance(part, dict) and part.get("type") == "text")
        value = "".join(part for part in parts if isinstance(part, str))
    return without_surrogates(value) if isinstance(value, str) else ""


def _logprobs(choice: Mapping[str, Any]) -> tuple[TokenLogprobs, ...]:
    value = choice.get("logprobs")
    return read_logprobs(value.get("content")) if isinstance(value, dict) else ()


def _count(body: Mapping[str, Any], key: str, origin: Origin) -> int | None:
    usage = body.get("usage")
    return count_in(usage, key, origin) if isinstance(usage, dict) else None


def _cached_tokens(body: Mapping[str, Any], origin: Origin) -> int | None:
    """Return the prompt tokens that came from the server's prompt cache, as OpenAI or llama.cpp reports them."""
    usage, timings = body.get("usage"), body.get("timings")
    details = usage.get("prompt_tokens_details") if isinstance(usage, dict) else None
    if isinstance(details, dict):
        return count_in(details, "cached_tokens", origin)
    return count_in(timings, "cache_n", origin) if isinstance(timings, dict) else None


def _timings(body: Mapping[str, Any], origin: Origin, latency_s: float) -> dict[str, float]:
    """Return the durations that llama.cpp reports, seconds; the call's other time counts as the wait for a slot."""
    timings = body.get("timings")
    keys = ("prompt_ms", "predicted_ms")
    if not isinstance(timings, dict) or not timings.keys() >= set(keys):
        return {}
    durations = seconds_in(timings, keys, origin, per_s=1e3)
    if durations is None:
        return {}
    prompt, output = durations
    return {"prompt": prompt, "output": output, "queue": max(0.0, latency_s - prompt - output)}


def _check_context(reply: Reply, context_length: int | None, origin: Origin) -> None:
    if context_length is None or reply.prompt_tokens is None:
        return
    used = reply.prompt_tokens + (reply.output_tokens or 0)
    if used > context_length:
        raise RequestError(
            f"{origin}: prompt ({reply.prompt_tokens} tokens) and reply ({reply.output_tokens}) overflowed the "
            f"context, so something was cut. Raise the server's context, and model.context_length ({context_length})."
        )
