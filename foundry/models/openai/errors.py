"""What a refusal by a server that speaks OpenAI's API means for the call, the run and the sweep."""

from __future__ import annotations

from collections.abc import Mapping

from foundry.errors import BackendError, RequestError, ServerError, TransientError
from foundry.models.http.transport import Origin, decoded, error_text, model_failure

BUSY = frozenset({429, 502, 503, 529})
TRANSIENT = frozenset({408, 409, 425, 499, 504})
HOPELESS: Mapping[int, str] = {
    401: "Put the key into {key_env}, or name its variable with model.server.api_key_env.",
    402: "The account has no means left.",
    403: "The key or the address may not use this model.",
    404: "Check the model's name, and that model.server.base_url ends as the server wants it, often with /v1.",
    405: "Check that model.server.base_url ends as the server wants it, often with /v1.",
}
"""Statuses that every call would meet, with the way out."""
FATAL: Mapping[str, str] = {
    "insufficient_quota": "The account has no means left.",
    "billing_hard_limit_reached": "The account has no means left.",
    "billing_not_active": "The account has no means left.",
    "invalid_api_key": "Put the key into {key_env}, or name its variable with model.server.api_key_env.",
    "model_not_found": "Check the model's name on the server.",
    "unsupported_parameter": "Leave {param} out, with null: model.options.{param}=null",
    "unsupported_value": "Change or leave out {param}, with null: model.options.{param}=null",
    "unknown_parameter": "Leave {param} out of model.options and model.extra.",
}
"""Codes and types that every call would meet, whatever the status, with the way out."""
TOO_LONG = frozenset({"context_length_exceeded", "exceed_context_size_error"})
BLIND = ("image input is not supported", "does not support image", "is not a multimodal model")
"""What texts hold that refuse images; llama.cpp gives one of them with status 500."""
ADVICE = "It would be refused again: check the options, the schema and the images against the model."


def refusal(
    origin: Origin, status: int, content: bytes, wait_s: float | None = None, *, key_env: str | None = None
) -> BackendError:
    """Return the error that a body with this status stands for.

    Args:
        origin: who answered.
        status: the HTTP status; not 200.
        content: the body.
        wait_s: how long the server asked to wait, seconds.
        key_env: name of the variable that should hold the key.
    """
    text = error_text(content)
    line = f"{origin}: {status} {text}".rstrip(".") + "."
    fields = {"key_env": key_env or "an environment variable", "param": _field(content, "param") or "the parameter"}
    codes = {_field(content, "code"), _field(content, "type")}
    way_on = next((FATAL[code] for code in sorted(codes) if code in FATAL), None) or HOPELESS.get(status)
    if way_on is not None:
        return ServerError(f"{line} {way_on.format(**fields)}")
    if codes & TOO_LONG:
        return RequestError(f"{line} The prompt does not fit: give the server a longer context, or shorten it.")
    if any(part in text for part in BLIND):
        return RequestError(f"{line} The model sees no images: set model.vision=false.")
    if status >= 500 and (failure := model_failure(origin, line)) is not None:
        return failure
    return _by_status(line, status, wait_s)


def _by_status(line: str, status: int, wait_s: float | None) -> BackendError:
    if status in BUSY:
        return TransientError(line, busy=True, retry_after_s=wait_s)
    if status in TRANSIENT or status >= 500:
        return TransientError(line, retry_after_s=wait_s)
    if status >= 400:
        return RequestError(f"{line} {ADVICE}")
    return ServerError(f"{line} This is no answer of an OpenAI API; check model.server.base_url.")


def _field(content: bytes, name: str) -> str:
    """Return a field of the error object as text; empty where there is none."""
    body = decoded(content)
    error = body.get("error", body) if isinstance(body, dict) else None
    value = error.get(name) if isinstance(error, dict) else None
    return str(value) if isinstance(value, str | int) else ""
