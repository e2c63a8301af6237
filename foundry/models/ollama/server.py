"""Ollama servers: their addresses in every form that OLLAMA_HOST takes, and what their refusals mean."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from foundry.errors import BackendError, RequestError, ServerError, TransientError
from foundry.models.http.hosts import parse_url
from foundry.models.http.transport import Origin, error_text, model_failure

DEFAULT_PORT = 11434
QUOTES = "\"'"


def parse_hosts(hosts: str | Iterable[str]) -> tuple[str, ...]:
    """Return the base URLs of one host, several separated by commas, or a list; each once, in order.

    Quotes around them are left out, as Ollama does with those that some shells leave in `OLLAMA_HOST`.
    """
    names = hosts.split(",") if isinstance(hosts, str) else list(hosts)
    stripped = [name.strip().strip(QUOTES) for name in names]
    return tuple(dict.fromkeys(parse_host(name) for name in stripped if name)) or (parse_host(""),)


def parse_host(host: str) -> str:
    """Return the base URL of a host such as `gpu1`, `:8080`, `0.0.0.0`, `[::1]:11434` or `https://x/ollama/`.

    Without a scheme the port is 11434, as for Ollama's own tools; with one it is the scheme's.
    """
    forms = "127.0.0.1:11434, gpu1 or https://example.org/ollama"
    return parse_url(host, what="Ollama host", port=DEFAULT_PORT, forms=forms)


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
