"""What a refusal by an Ollama server means for the call, the run and the sweep."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime

from foundry.errors import BackendError, RequestError, ServerError, TransientError
from foundry.models.base import Reply, UnusableReply
from foundry.worlds.base import ABORTED

WAYS_ON = (
    "Start Ollama (ollama serve, https://ollama.com/download), set OLLAMA_HOST, "
    "or try scripted models: foundry model=scripted/random"
)

BUSY = frozenset({429, 502, 503})
TRANSIENT = frozenset({408, 504})
HOPELESS: Mapping[int, str] = {
    401: "It wants a key that foundry does not send; name another host.",
    403: "Call it by an address it allows (OLLAMA_HOST), or set OLLAMA_ORIGINS on the server.",
    404: "Get the model with `ollama pull {model}`, or check the host if it is not an Ollama server.",
}
"""Statuses that every call would meet, with the way out."""
BAD_SETTINGS = ('option "', "invalid format")
"""How the text of a 500 begins that settings cause, and not the runner."""
TOKEN_REPEAT = "token repeat limit"
LONGEST_TEXT = 300


@dataclass(frozen=True, slots=True)
class Origin:
    """Who answered: the server's base URL and version, and the model."""

    host: str
    model: str
    version: str | None = None

    def __str__(self) -> str:
        return f"Ollama at {self.host}, model '{self.model}'"


def refusal(origin: Origin, status: int, content: bytes, retry_after: str | None = None) -> BackendError:
    """Return the error that a body with this status stands for.

    Args:
        origin: who answered.
        status: the HTTP status; not 200.
        content: the body.
        retry_after: the header `Retry-After`.
    """
    text = error_text(content)
    line = f"{origin}: {status} {text}".rstrip(".") + "."
    if status in HOPELESS:
        return ServerError(f"{line} {HOPELESS[status].format(model=origin.model)}")
    if status in BUSY:
        return TransientError(line, busy=True, retry_after_s=seconds_to_wait(retry_after, datetime.now(UTC)))
    if status in TRANSIENT:
        return TransientError(line)
    if status >= 500:
        return _server_failure(origin, line, text)
    if status >= 400:
        advice = "It would be refused again: check num_ctx, think, format and images against the model."
        return RequestError(f"{line} {advice}")
    return ServerError(f"{line} This is no answer of an Ollama API; check the host.")


def _server_failure(origin: Origin, line: str, text: str) -> BackendError:
    if TOKEN_REPEAT in text:
        return UnusableReply(line, aborted_reply(origin))
    if text.startswith(BAD_SETTINGS):
        return ServerError(f"{line} Correct it in the model's settings.")
    return TransientError(line)


def aborted_reply(origin: Origin) -> Reply:
    """Return the reply that stands for a model that gave up."""
    return Reply(text="", ending=ABORTED, host=origin.host, server_version=origin.version)


def error_text(content: bytes) -> str:
    """Return what a refusal says in one short line, out of the JSON it may be wrapped in, twice even."""
    text = content.decode("utf-8", "replace").strip()
    while text.startswith("{"):
        try:
            inner = json.loads(text).get("error")
        except ValueError:
            break
        if isinstance(inner, dict):
            inner = inner.get("message")
        if not isinstance(inner, str):
            break
        text = inner.strip()
    line = " ".join(text.split())
    return line if len(line) <= LONGEST_TEXT else line[:LONGEST_TEXT] + "..."


def seconds_to_wait(retry_after: str | None, now: datetime) -> float | None:
    """Return the seconds that a `Retry-After` header asks for, given as a number or as a date, else None."""
    if retry_after is None:
        return None
    try:
        seconds = float(retry_after)
    except ValueError:
        return _seconds_until(retry_after, now)
    return seconds if math.isfinite(seconds) and seconds >= 0 else None


def _seconds_until(date: str, now: datetime) -> float | None:
    try:
        moment = parsedate_to_datetime(date)
    except ValueError:
        return None
    if moment.tzinfo is None:
        moment = moment.replace(tzinfo=UTC)
    return max(0.0, (moment - now).total_seconds())
