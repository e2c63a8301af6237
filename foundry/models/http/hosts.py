"""Reads the addresses of servers with the same model, and chooses a server for each call."""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from urllib.parse import urlsplit

from yarl import URL

from foundry.errors import HostsDifferError, InputError, TransientError
from foundry.models.base import ModelInfo, every_run
from foundry.models.serving import RUN

SCHEME_PORTS = {"http": 80, "https": 443}
ANY_ADDRESS = {"": "127.0.0.1", "0.0.0.0": "127.0.0.1", "::": "::1"}
"""Addresses such as 0.0.0.0, on which a server listens but which no client can call; each has an address to call."""


def parse_url(host: str, *, what: str, port: int, forms: str) -> str:
    """Return the base URL of a server that a user wrote as `gpu1`, `:8080`, `[::1]:8000` or `https://x/path/`."""
    shown = host.rpartition("@")[2]

    def refusal(why: str) -> InputError:
        return InputError(f"{what} '{shown}' cannot be read: {why}. Write it as in {forms}.")

    scheme, separator, rest = host.strip().rpartition("://")
    scheme = scheme.lower() or "http"
    if scheme not in SCHEME_PORTS:
        raise refusal("its scheme is neither http nor https")
    if shown != host:  # before any message that would repeat it
        raise refusal("it must not contain a user or password")
    if rest.count(":") > 1 and not rest.startswith("["):
        rest = f"[{rest}]"
    try:
        parts = urlsplit(f"{scheme}://{rest}")
        given_port = parts.port
    except ValueError as error:
        raise refusal(str(error)) from None
    if parts.query or parts.fragment:
        raise refusal("it must not contain a query or fragment")
    name = ANY_ADDRESS.get(parts.hostname or "", parts.hostname or "")
    if any(character.isspace() or not character.isprintable() for character in f"{name}{parts.path}"):
        raise refusal("it contains a space or a control character")
    if given_port is None:
        given_port = SCHEME_PORTS[scheme] if separator else port
    address = f"[{name}]" if ":" in name else name
    url = f"{scheme}://{address}:{given_port}{parts.path.rstrip('/')}"
    try:
        URL(url)
    except ValueError as error:
        raise refusal(str(error)) from None
    return url


def parse_urls(hosts: str | Iterable[str], parse: Callable[[str], str]) -> tuple[str, ...]:
    """Return the base URLs of hosts, given as a list or as one text with commas; each once, in order.

    Quotes around a host are ignored, as in Ollama, since some shells leave quotes in environment variables.
    """
    names = hosts.split(",") if isinstance(hosts, str) else hosts
    stripped = (name.strip().strip("\"'") for name in names)
    return tuple(dict.fromkeys(parse(name) for name in stripped if name))


def agreed(infos: Mapping[str, ModelInfo], advice: str) -> ModelInfo:
    """Return the facts about a model if all servers, given by base URL, have the same weights; else raise an error."""
    first = next(iter(infos.values()))
    if len({info.identity for info in infos.values()}) > 1:
        digests = ", ".join(f"{host} has {(info.identity or 'none')[:12]}" for host, info in infos.items())
        raise HostsDifferError(f"Model '{first.name}' differs between hosts: {digests}.", advice=advice)
    states = {host: state for info in infos.values() for host, state in info.states.items()}
    return replace(first, states=states)


MEMORY = 50
"""Number of recent answers per host from which its capacity is estimated."""
LEAST_ANSWERED = 1.0
"""A host with fewer recent answers counts as one with this number, so that a slow host is tried again."""
PREFERENCE = 1 / 8
"""Every run has a home host. A call goes to another host only if the load of that host is smaller by more than this
share of the home host's load. If a host has fewer than eight calls in flight, this share is less than one call, so no
slot of a server stays empty.
"""
MOST_HOMES = 128
"""Maximum number of runs for which the host is remembered. More runs than this are never open at the same time."""


class HostPool:
    """Chooses for each call the server with the fewest calls in flight relative to the server's capacity.

    The capacity of a server is the square root of its number of recent answers. Without the root, a server with more
    calls would answer more and get ever more calls. With the root, equal servers get equal numbers, and a faster
    server, or one with more slots, gets more. A failing server answers fast and would attract every call. So each
    failure of a server counts as one more call in flight, until this server answers again. Failures are also forgotten
    while other servers answer, so a server that was down is tried again, even with few calls in flight.

    The prompts of a run begin alike, so its calls go to one host, which then has the beginning in its prompt cache. If
    calls wait, those for a host with room come first. A host may get a few calls more than its part, since the runs
    whose home it is prefer it.
    """

    def __init__(self, hosts: tuple[str, ...]) -> None:
        self.hosts = hosts
        self._in_flight = dict.fromkeys(hosts, 0)
        self._failures = dict.fromkeys(hosts, 0.0)
        self._answered = dict.fromkeys(hosts, float(MEMORY))
        self._homes: dict[str, str] = {}

    @contextmanager
    def least_loaded(self) -> Iterator[str]:
        """Choose the host of one call, yield its base URL, and count the call as in flight meanwhile."""
        host = self._choice()
        self._in_flight[host] += 1
        try:
            yield host
        except TransientError:
            self._failures[host] += 1
            raise
        else:
            self._failures[host] = 0.0
            self._note_answer(host)
        finally:
            self._in_flight[host] -= 1

    def next_served(self) -> Callable[[str | None], bool]:
        """Return a function that tells, for a run's id, whether the run's next call can start on a host with room."""
        if len(self.hosts) == 1:
            return every_run
        served = {min(self.hosts, key=self._load), *(host for host in self.hosts if self._failures[host]), None}
        return lambda run: self._homes.get(run or "") in served

    def _choice(self) -> str:
        """Return the run's home host, or another host whose load is smaller by more than the share `PREFERENCE`."""
        if len(self.hosts) == 1:
            return self.hosts[0]
        least, run = min(self.hosts, key=self._load), RUN.get()
        home = least if run is None else self._home_of(run)
        leeway = PREFERENCE if len(self._homes) > 1 else 0.0
        return home if self._load(home)[0] * (1 - leeway) <= self._load(least)[0] else least

    def _home_of(self, run: str) -> str:
        """Return the host of a run; a new run gets the host with the fewest runs relative to its capacity."""
        home = self._homes.pop(run, None)
        if home is None:
            homes = Counter(self._homes.values())
            home = min(self.hosts, key=lambda host: homes[host] / math.sqrt(self._answered[host]))
        self._homes[run] = home  # the last used run is at the end
        if len(self._homes) > MOST_HOMES:
            del self._homes[next(iter(self._homes))]
        return home

    def _load(self, host: str) -> tuple[float, float]:
        """Return a host's load: calls in flight relative to capacity, and (for equal loads) recent answers."""
        answered = self._answered[host]
        return (self._in_flight[host] + self._failures[host]) / math.sqrt(answered), answered

    def _note_answer(self, host: str) -> None:
        weight = 1 - 1 / (MEMORY * len(self.hosts))
        for each, answered in self._answered.items():
            self._answered[each] = max(LEAST_ANSWERED, answered * weight)
            self._failures[each] *= weight
        self._answered[host] += 1
