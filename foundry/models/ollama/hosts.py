"""Addresses of Ollama servers, in every form that `OLLAMA_HOST` takes."""

from __future__ import annotations

from collections.abc import Iterable

from foundry.models.http.hosts import parse_url

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
