"""Addresses of Ollama servers, in every form that `OLLAMA_HOST` takes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from urllib.parse import urlsplit

import httpx

from foundry.errors import InputError, TransientError

DEFAULT_PORT = 11434
SCHEME_PORTS = {"http": 80, "https": 443}
ANY_ADDRESS = {"": "127.0.0.1", "0.0.0.0": "127.0.0.1", "::": "::1"}
"""Addresses that a server may listen on and no client can call, with the one to call instead."""


def parse_hosts(hosts: str | Iterable[str]) -> tuple[str, ...]:
    """Return the base URLs of one host, several separated by commas, or a list; each once, in order."""
    names = hosts.split(",") if isinstance(hosts, str) else list(hosts)
    stripped = [name.strip() for name in names]
    return tuple(dict.fromkeys(parse_host(name) for name in stripped if name)) or (parse_host(""),)


def parse_host(host: str) -> str:
    """Return the base URL of a host such as `gpu1`, `:8080`, `0.0.0.0`, `[::1]:11434` or `https://x/ollama/`.

    Without a scheme the port is 11434, as for Ollama's own tools; with one it is the scheme's.
    """
    scheme, separator, rest = host.strip().rpartition("://")
    scheme = scheme.lower() or "http"
    if scheme not in SCHEME_PORTS:
        raise _refusal(host, "its scheme is neither http nor https")
    if rest.count(":") > 1 and not rest.startswith("["):
        rest = f"[{rest}]"
    try:
        parts = urlsplit(f"{scheme}://{rest}")
        port = parts.port
    except ValueError as error:
        raise _refusal(host, str(error)) from None
    if parts.username is not None or parts.query or parts.fragment:
        raise _refusal(host, "it may hold no user, query or fragment")
    name = ANY_ADDRESS.get(parts.hostname or "", parts.hostname or "")
    if any(character.isspace() for character in name):
        raise _refusal(host, "its name holds a space")
    if port is None:
        port = SCHEME_PORTS[scheme] if separator else DEFAULT_PORT
    address = f"[{name}]" if ":" in name else name
    url = f"{scheme}://{address}:{port}{parts.path.rstrip('/')}"
    try:
        httpx.URL(url)
    except httpx.InvalidURL as error:
        raise _refusal(host, str(error)) from None
    return url


def _refusal(host: str, why: str) -> InputError:
    forms = "127.0.0.1:11434, gpu1 or https://example.org/ollama"
    return InputError(f"Ollama host '{host}' cannot be read: {why}. Write it as in {forms}.")


class HostPool:
    """Equal servers; each call goes to the one with the fewest calls in flight, ties by order.

    A server that fails answers fast and would draw every call, so each failure in a row weighs like one
    more call in flight until it answers again.
    """

    def __init__(self, hosts: tuple[str, ...]) -> None:
        self.hosts = hosts
        self._in_flight = dict.fromkeys(hosts, 0)
        self._failures = dict.fromkeys(hosts, 0)

    @contextmanager
    def least_loaded(self) -> Iterator[str]:
        """Count one call against the least loaded host, whose base URL is yielded."""
        host = min(self.hosts, key=lambda host: self._in_flight[host] + self._failures[host])
        self._in_flight[host] += 1
        try:
            yield host
        except TransientError:
            self._failures[host] += 1
            raise
        else:
            self._failures[host] = 0
        finally:
            self._in_flight[host] -= 1
