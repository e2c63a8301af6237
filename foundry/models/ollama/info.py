"""Lists the models that are installed on Ollama servers, and installs more."""

import asyncio
import json
import os
from collections.abc import AsyncIterator, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import httpx

from foundry.errors import InputError
from foundry.models.http.transport import error_text
from foundry.models.ollama.ollama_server import WAYS_ON, context_length, parse_hosts

READ_AT_IMPORT = ("ollama_host", "ssl_cert_file", "ssl_cert_dir", "_proxy")
"""Suffixes of environment variables that the `ollama` package reads when it is imported."""


@contextmanager
def _without_variables() -> Iterator[None]:
    """Hide the environment variables with which the import of `ollama` could fail, such as a SOCKS proxy."""
    hidden = {name: os.environ.pop(name) for name in list(os.environ) if name.lower().endswith(READ_AT_IMPORT)}
    try:
        yield
    finally:
        os.environ.update(hidden)


with _without_variables():
    from ollama import AsyncClient, ResponseError

FETCHING = (
    "The server downloads the model, so its machine must reach the registry (registry.ollama.ai, or hf.co for a name "
    "such as hf.co/...). The registry must have a model with that name and tag."
)
TIMEOUT = httpx.Timeout(30.0, connect=5.0)


@dataclass(frozen=True, slots=True)
class InstalledModel:
    """A model that is installed on a server.

    Attributes:
        digest: SHA-256 of the manifest, which covers weights, template and parameters.
        size: size on disk, bytes.
        context_length: longest context in tokens, or None where unknown.
        loaded: whether the server has the model in memory.
    """

    host: str
    name: str
    digest: str
    size: int
    parameter_size: str
    quantization: str
    context_length: int | None
    capabilities: tuple[str, ...]
    loaded: bool


async def list_models(hosts: str | Iterable[str]) -> list[InstalledModel]:
    """Return every model on the given hosts, sorted by host and name; write hosts as in `OLLAMA_HOST`."""
    models_by_host = await asyncio.gather(*map(_installed, parse_hosts(hosts)))
    return [model for models in models_by_host for model in models]


@dataclass(frozen=True, slots=True)
class PullProgress:
    """Progress of a download.

    Attributes:
        status: present step of the download, in the server's words.
        completed: downloaded bytes of the current layer; 0 if not reported.
        total: size of the current layer, bytes; 0 if not reported.
    """

    status: str
    completed: int
    total: int


async def pull_model(name: str, hosts: str | Iterable[str]) -> AsyncIterator[PullProgress]:
    """Let each host download a model, one host after the other, and yield the progress."""
    for host in parse_hosts(hosts):
        try:
            with _reading(host):
                async with _client(host, timeout=None) as client:
                    async for part in await client.pull(name, stream=True):
                        yield PullProgress(part.status or "", part.completed or 0, part.total or 0)
        except InputError as error:
            if not isinstance(error.__cause__, ResponseError):
                raise
            raise InputError(f"'{name}' was not downloaded. {error} {FETCHING}") from error


async def _installed(host: str) -> list[InstalledModel]:
    with _reading(host):
        async with _client(host) as client:
            rows = (await client.list()).models
            running = {row.digest for row in (await client.ps()).models}
            shown = await asyncio.gather(*(client.show(str(row.model)) for row in rows))
    return [
        InstalledModel(
            host=host,
            name=str(row.model),
            digest=row.digest or "",
            size=int(row.size or 0),
            parameter_size=(row.details and row.details.parameter_size) or "",
            quantization=(row.details and row.details.quantization_level) or "",
            context_length=context_length(show.modelinfo or {}),
            capabilities=tuple(show.capabilities or ()),
            loaded=row.digest in running,
        )
        for row, show in sorted(zip(rows, shown, strict=True), key=lambda pair: str(pair[0].model))
    ]


def _client(host: str, timeout: Any = TIMEOUT) -> AsyncClient:
    """Return a client that ignores proxies, redirects and any key in the environment."""
    # Reading all certificates takes longer than the calls, and is not needed: without redirects, http stays http.
    verify = host.startswith("https:")
    return AsyncClient(host, timeout=timeout, follow_redirects=False, trust_env=False, auth=_without_key, verify=verify)


def _without_key(request: httpx.Request) -> httpx.Request:
    """Remove OLLAMA_API_KEY from a request, since the client would send it to any host."""
    request.headers.pop("authorization", None)
    return request


@contextmanager
def _reading(host: str) -> Iterator[None]:
    try:
        yield
    except (ConnectionError, httpx.TransportError) as error:
        raise InputError(f"No Ollama server answers at {host} ({type(error).__name__}).", advice=WAYS_ON) from error
    except ResponseError as error:
        status = f" ({error.status_code})" if error.status_code > 0 else ""
        # The package passes on the value of the key `error`, which is not always a text.
        text = error.error if isinstance(error.error, str) else json.dumps(error.error)
        raise InputError(f"Ollama at {host} answers{status}: {error_text(text.encode())}.") from error
    except ValueError as error:
        raise InputError(f"The server at {host} is not an Ollama server.", advice=WAYS_ON) from error
