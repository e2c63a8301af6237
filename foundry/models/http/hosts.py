"""Addresses of equal servers, and which of them gets the next call."""

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from urllib.parse import urlsplit

from yarl import URL

from foundry.errors import HostsDifferError, InputError, TransientError
from foundry.models.base import ModelInfo, every_run
from foundry.models.serving import RUN

SCHEME_PORTS = {"http": 80, "https": 443}
ANY_ADDRESS = {"": "127.0.0.1", "0.0.0.0": "127.0.0.1", "::": "::1"}
"""Addresses that a server may listen on and no client can call, with the one to call instead."""


def parse_url(host: str, *, what: str, port: int, forms: str) -> str:
    """Return the base URL of a host such as `gpu1`, `:8080`, `[::1]:8000` or `https://x/path/`."""
    shown = host.rpartition("@")[2]

    def refusal(why: str) -> InputError:
        return InputError(f"{what} '{shown}' cannot be read: {why}. Write it as in {forms}.")

    scheme, separator, rest = host.strip().rpartition("://")
    scheme = scheme.lower() or "http"
    if scheme not in SCHEME_PORTS:
        raise refusal("its scheme is neither http nor https")
    if shown != host:  # before anything that would repeat it
        raise refusal("it may hold no user or password")
    if rest.count(":") > 1 and not rest.startswith("["):
        rest = f"[{rest}]"
    try:
        parts = urlsplit(f"{scheme}://{rest}")
        given_port = parts.port
    except ValueError as error:
        raise refusal(str(error)) from None
    if parts.query or parts.fragment:
        raise refusal("it may hold no query or fragment")
    name = ANY_ADDRESS.get(parts.hostname or "", parts.hostname or "")
    if any(character.isspace() or not character.isprintable() for character in f"{name}{parts.path}"):
        raise refusal("it holds a space or a control character")
    if given_port is None:
        given_port = SCHEME_PORTS[scheme] if separator else port
    address = f"[{name}]" if ":" in name else name
    url = f"{scheme}://{address}:{given_port}{parts.path.rstrip('/')}"
    try:
        URL(url)
    except ValueError as error:
        raise refusal(str(error)) from None
    return url


def agreed(infos: Mapping[str, ModelInfo], advice: str) -> ModelInfo:
    """Return the one answer of several servers, by base URL."""
    first = next(iter(infos.values()))
    if len({info.identity for info in infos.values()}) > 1:
        digests = ", ".join(f"{host} has {(info.identity or 'none')[:12]}" for host, info in infos.items())
        raise HostsDifferError(f"Model '{first.name}' is not the same on all hosts: {digests}. {advice}")
    states = {host: state for info in infos.values() for host, state in info.states.items()}
    return replace(first, states=states)


MEMORY = 50
"""Answers that are remembered for each host."""
LEAST_ANSWERED = 1.0
"""So many are taken to be answered at least, so that a host which was slow is seen to be fast again."""
PREFERENCE = 1 / 8
"""A run's own host may have this share of its calls in flight more than its part: none where it has fewer than eight,
so that no slot of another stays empty."""
MOST_HOMES = 128
"""Runs whose hosts are remembered; so many are never open at once."""


class HostPool:
    """Equal servers; each call goes to the one with the fewest calls in flight for what it can do.

    What it can do is the root of what it answered of late. In proportion to the answers themselves, whoever got more
    calls would answer more and get more still; by the root, equal servers get equally many, and of unequal ones the
    faster one, or the one that works on more calls at once, gets more.
    A server that fails answers fast and would draw every call, so each failure in a row weighs like one
    more call in flight until it answers again. As others answer, failures are forgotten at the rate at which answers
    are: one that was down is asked again by and by, however few calls are in flight.

    A run's calls share the beginnings of their prompts, so they go to one host, which has these in its prompt cache:
    of the calls that wait, those come first whose host has room, and a host may have a few of its own more.
    """

    def __init__(self, hosts: tuple[str, ...]) -> None:
        self.hosts = hosts
        self._in_flight = dict.fromkeys(hosts, 0)
        self._failures = dict.fromkeys(hosts, 0.0)
        self._answered = dict.fromkeys(hosts, float(MEMORY))
        self._homes: dict[str, str] = {}

    @contextmanager
    def least_loaded(self) -> Iterator[str]:
        """Count one call against the least loaded host or the run's own, whose base URL is yielded."""
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
        """Return what says of a run whether its calls go to the least loaded host by preference, or to any."""
        if len(self.hosts) == 1:
            return every_run
        served = {min(self.hosts, key=self._load), *(host for host in self.hosts if self._failures[host]), None}
        return lambda run: self._homes.get(run or "") in served

    def _choice(self) -> str:
        """Return the run's own host, unless another has less to do by more than the leeway."""
        if len(self.hosts) == 1:
            return self.hosts[0]
        least, run = min(self.hosts, key=self._load), RUN.get()
        home = least if run is None else self._home_of(run)
        leeway = PREFERENCE if len(self._homes) > 1 else 0.0
        return home if self._load(home)[0] * (1 - leeway) <= self._load(least)[0] else least

    def _home_of(self, run: str) -> str:
        """Return the host of a run; a new one gets that with the fewest runs for what it can do."""
        home = self._homes.pop(run, None)
        if home is None:
            homes = Counter(self._homes.values())
            home = min(self.hosts, key=lambda host: homes[host] / math.sqrt(self._answered[host]))
        self._homes[run] = home  # the one asked for last stands last
        if len(self._homes) > MOST_HOMES:
            del self._homes[next(iter(self._homes))]
        return home

    def _load(self, host: str) -> tuple[float, float]:
        """Return the calls in flight over what the host can do; then what it answered, so that equals take turns."""
        answered = self._answered[host]
        return (self._in_flight[host] + self._failures[host]) / math.sqrt(answered), answered

    def _note_answer(self, host: str) -> None:
        weight = 1 - 1 / (MEMORY * len(self.hosts))
        for each, answered in self._answered.items():
            self._answered[each] = max(LEAST_ANSWERED, answered * weight)
            self._failures[each] *= weight
        self._answered[host] += 1
