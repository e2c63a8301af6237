"""Reads the addresses of Ollama servers, their reports on a model, and their errors."""

from collections.abc import Iterable, Mapping
from typing import Any

from foundry.errors import BackendError, InputError, RequestError, ServerError, TransientError, not_found
from foundry.models.base import Loaded, ModelInfo
from foundry.models.http.hosts import parse_url, parse_urls
from foundry.models.http.transport import Origin, error_text, length_in, model_failure, name_in, names_in

DEFAULT_PORT = 11434
WAYS_ON = (
    "Start Ollama (ollama serve, https://ollama.com/download), set OLLAMA_HOST, "
    "or try scripted models: foundry model=scripted/random"
)
BUSY = frozenset({429, 502, 503})
TRANSIENT = frozenset({408, 499, 504})
HOPELESS: Mapping[int, str] = {
    401: "It requires a key that foundry does not send; name another host.",
    403: "Call it by an address it allows (OLLAMA_HOST), or set OLLAMA_ORIGINS on the server.",
    404: "Get the model with `ollama pull {model}`, or check the host if it is not an Ollama server.",
}
"""HTTP statuses of errors that a repeated call would get again; each has advice to the user."""
BAD_SETTINGS = ('option "', "invalid format")
"""First words of errors with status 500 that wrong settings cause, and not a failure of the server."""
CLOUD_DISABLED = "cloud is disabled"


def parse_hosts(hosts: str | Iterable[str]) -> tuple[str, ...]:
    """Return the base URLs of hosts; without any, the URL of an Ollama server on this machine."""
    return parse_urls(hosts, parse_host) or (parse_host(""),)


def parse_host(host: str) -> str:
    """Return the base URL of a host such as `gpu1`, `:8080`, `0.0.0.0`, `[::1]:11434` or `https://x/ollama/`.

    Without a scheme the port is 11434, as in Ollama's own tools; with a scheme it is the scheme's default.
    """
    forms = "127.0.0.1:11434, gpu1 or https://example.org/ollama"
    return parse_url(host, what="Ollama host", port=DEFAULT_PORT, forms=forms)


def refusal(origin: Origin, status: int, content: bytes, wait_s: float | None = None) -> BackendError:
    """Return the error for a response, by its status and body."""
    text = error_text(content)
    line = f"{origin}: {status} {text}".rstrip(".") + "."
    if CLOUD_DISABLED in text:
        advice = "The model runs in Ollama's cloud: name one that is installed on the host."
        return ServerError(line, advice=advice)
    if status in HOPELESS:
        return ServerError(line, advice=HOPELESS[status].format(model=origin.model))
    if status in BUSY:
        return TransientError(line, busy=True, retry_after_s=wait_s)
    if status in TRANSIENT:
        return TransientError(line)
    if status >= 500:
        return model_failure(origin, line) or _server_failure(line, text)
    if status >= 400:
        advice = "It would be refused again: check num_ctx, think, format and images against the model."
        return RequestError(line, advice=advice)
    return ServerError(line, advice="This is not an answer of an Ollama API; check the host.")


def _server_failure(line: str, text: str) -> BackendError:
    if text.startswith(BAD_SETTINGS):
        return ServerError(line, advice="Correct the settings of the model.")
    return TransientError(line)


def full_tag(name: str) -> str:
    """Return the name of a model with its tag, which is `latest` by default."""
    return name if ":" in name.rsplit("/", 1)[-1] else f"{name}:latest"


def installed_row(listing: Mapping[str, Any], name: str, host: str) -> Mapping[str, Any]:
    """Return the entry of this model in the list of models that `GET /api/tags` gives."""
    models = listing.get("models")
    if not isinstance(models, list):
        raise InputError(f"The server at {host} is not an Ollama server.", advice=WAYS_ON)
    rows = {str(row.get("model")): row for row in models if isinstance(row, dict)}
    tag = next((tag for tag in rows if tag.casefold() == full_tag(name).casefold()), None)
    if tag is None:
        raise not_found("Model", name, rows, f"Get the model on {host} with: ollama pull {name}")
    return rows[tag]


def described(name: str, row: Mapping[str, Any], shown: Mapping[str, Any], version: str, host: str) -> ModelInfo:
    """Return the facts about a model, from its entry in a server's list of models and the server's details about it.

    If a model was removed and installed again, it has its old digest, but a new time of change.
    """
    return ModelInfo(
        name=name,
        digest=name_in(row.get("digest")),
        server_version=version,
        states={host: name_in(row.get("modified_at")) or ""},
        capabilities=names_in(shown.get("capabilities")),
        context_length=context_length(shown.get("model_info")),
        remote=remote_in({**shown, **row}),
    )


def remote_in(said: Mapping[str, Any]) -> str | None:
    """Return the model and address to which a server passes calls, if its list or its reply names them."""
    model, host = name_in(said.get("remote_model")), name_in(said.get("remote_host"))
    return f"{model or 'a model'} at {host or 'an unknown address'}" if model or host else None


def loaded_in(row: Mapping[str, Any]) -> Loaded:
    """Return the report on a loaded model, read from its entry in the answer to `GET /api/ps`."""
    size, on_gpu, on_cpu = length_in(row.get("size")), row.get("size_vram"), None
    if size is not None and isinstance(on_gpu, int) and 0 <= on_gpu <= size:
        on_cpu = 1 - on_gpu / size
    return Loaded(context_length=length_in(row.get("context_length")), on_cpu=on_cpu)


def context_length(info: Any) -> int | None:
    """Return the longest context of a model, tokens, from a key such as `llama.context_length`."""
    if not isinstance(info, Mapping):
        return None
    return length_in(info.get(f"{info.get('general.architecture')}.context_length"))
