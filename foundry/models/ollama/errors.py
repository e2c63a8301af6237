"""What a refusal by an Ollama server means for the call, the run and the sweep."""

from __future__ import annotations

from collections.abc import Mapping

from foundry.errors import BackendError, RequestError, ServerError, TransientError
from foundry.models.http.transport import Origin, error_text, model_failure

WAYS_ON = (
    "Start Ollama (ollama serve, https://ollama.com/download), set OLLAMA_HOST, "
    "or try scripted models: foundry model=scripted/random"
)

BUSY = frozenset({429, 502, 503})
TRANSIENT = frozenset({408, 499, 504})
HOPELESS: Mapping[int, str] = {
    401: "It wants a key that foundry does not send; name another host.",
    403: "Call it by an address it allows (OLLAMA_HOST), or set OLLAMA_ORIGINS on the server.",
    404: "Get the model with `ollama pull {model}`, or check the host if it is not an Ollama server.",
}
"""Statuses that every call would meet, with the way out."""
BAD_SETTINGS = ('option "', "invalid format")
"""How the text of a 500 begins that settings cause, and not the runner."""
CLOUD_DISABLED = "cloud is disabled"


def refusal(origin: Origin, status: int, content: bytes, wait_s: float | None = None) -> BackendError:
    """Return the error that a body with this status stands for.

    Args:
        origin: who answered.
        status: the HTTP status; not 200.
        content: the body.
        wait_s: how long the server asked to wait, seconds.
    """
    text = error_text(content)
    line = f"{origin}: {status} {text}".rstrip(".") + "."
    if CLOUD_DISABLED in text:
        return ServerError(f"{line} The model runs in Ollama's cloud: name one that is installed on the host.")
    if status in HOPELESS:
        return ServerError(f"{line} {HOPELESS[status].format(model=origin.model)}")
    if status in BUSY:
        return TransientError(line, busy=True, retry_after_s=wait_s)
    if status in TRANSIENT:
        return TransientError(line)
    if status >= 500:
        return model_failure(origin, line) or _server_failure(line, text)
    if status >= 400:
        advice = "It would be refused again: check num_ctx, think, format and images against the model."
        return RequestError(f"{line} {advice}")
    return ServerError(f"{line} This is no answer of an Ollama API; check the host.")


def _server_failure(line: str, text: str) -> BackendError:
    if text.startswith(BAD_SETTINGS):
        return ServerError(f"{line} Correct it in the model's settings.")
    return TransientError(line)
