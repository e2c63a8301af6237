"""What an Ollama server says about one model, read from its replies; nothing here opens a connection."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from foundry.errors import InputError, not_found
from foundry.models.base import Loaded, ModelInfo
from foundry.models.http.transport import length_in, name_in, names_in
from foundry.models.ollama.server import WAYS_ON


def full_tag(name: str) -> str:
    """Return the name with its tag; without one Ollama takes `latest`."""
    return name if ":" in name.rsplit("/", 1)[-1] else f"{name}:latest"


def installed_row(listing: Mapping[str, Any], name: str, host: str) -> Mapping[str, Any]:
    """Return the row of a model in the object that `GET /api/tags` gave.

    Raises:
        InputError: this is no list of models, or the model is not in it.
    """
    models = listing.get("models")
    if not isinstance(models, list):
        raise InputError(f"What answers at {host} is not an Ollama server. {WAYS_ON}")
    rows = {str(row.get("model")): row for row in models if isinstance(row, dict)}
    tag = next((tag for tag in rows if tag.casefold() == full_tag(name).casefold()), None)
    if tag is None:
        raise not_found("Model", name, rows, f"Get it on {host} with: ollama pull {name}")
    return rows[tag]


def described(name: str, row: Mapping[str, Any], shown: Mapping[str, Any], version: str, host: str) -> ModelInfo:
    """Return what is known of a model on one server.

    A tag that is taken away and put back has its digest again, but is written anew.

    Args:
        name: what the model is called here.
        row: its row in the list of models.
        shown: the object that `POST /api/show` gave.
        version: version of the server.
        host: base URL of the server.
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
    """Return the model and the address that a server passes calls on to, as it says in a row or a reply."""
    model, host = name_in(said.get("remote_model")), name_in(said.get("remote_host"))
    return f"{model or 'a model'} at {host or 'an unknown address'}" if model or host else None


def loaded_in(row: Mapping[str, Any]) -> Loaded:
    """Return how a server runs a model, by its row in the object that `GET /api/ps` gave."""
    size, on_gpu, on_cpu = length_in(row.get("size")), row.get("size_vram"), None
    if size is not None and isinstance(on_gpu, int) and 0 <= on_gpu <= size:
        on_cpu = 1 - on_gpu / size
    return Loaded(context_length=length_in(row.get("context_length")), on_cpu=on_cpu)


def context_length(info: Any) -> int | None:
    """Return the longest context in tokens, which stands under the name of the model's architecture."""
    if not isinstance(info, Mapping):
        return None
    return length_in(info.get(f"{info.get('general.architecture')}.context_length"))
