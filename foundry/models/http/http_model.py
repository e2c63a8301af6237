"""The base class of models behind HTTP servers, for any API."""

import copy
from collections.abc import Callable, Mapping
from typing import Any

from foundry.errors import InputError, not_found
from foundry.models.base import Model
from foundry.models.http.hosts import HostPool
from foundry.models.http.pausing import Pause
from foundry.models.http.transport import Transport
from foundry.models.serving import HttpServing, ServedModel

FORMATS = (None, "schema")


class HttpModel(ServedModel):
    """Asks one or more servers with the same model.

    The constructor of a subclass names the servers (`_reach`), and sets the schemas of replies (`_schemas`).
    """

    server: HttpServing
    _pool: HostPool
    _pauses: Mapping[str, Pause]
    _transport: Transport
    _schemas: Mapping[str, Any] | None
    settings: Any

    def _reach(self, hosts: tuple[str, ...], ways_on: str, headers: Mapping[str, str] | None = None) -> None:
        self._pool = HostPool(hosts)
        self._pauses = {host: Pause(self.server.longest_pause_s) for host in hosts}
        self._transport = Transport(self.server, ways_on, headers)

    @property
    def hosts(self) -> tuple[str, ...]:
        """Base URLs of the servers."""
        return self._pool.hosts

    @property
    def kinds(self) -> tuple[str, ...] | None:
        """The kinds of question that have a schema; None, for any kind, if replies are free text."""
        return None if self._schemas is None else tuple(self._schemas)

    def next_served(self) -> Callable[[str | None], bool]:
        """Return a function that says whether a run's next call should go to the server that has the most room now."""
        return self._pool.next_served()

    @property
    def connections(self) -> int:
        """Number of connections opened so far."""
        return self._transport.opened

    def _on_each_host(self, settings: Any) -> Mapping[str, Model]:
        """Return a copy of the model for each server, by base URL; it has these settings, and asks only its server."""
        models = {host: copy.copy(self) for host in self.hosts if self.server.canary}
        for host, model in models.items():
            model.settings, model._schemas, model._pool = settings, None, HostPool((host,))
        return models

    async def close(self) -> None:
        """Close all connections; a later call opens new ones, even in another event loop."""
        await self._transport.close()


def schemas_of(format: str | None, schemas: Mapping[str, Any] | None) -> Mapping[str, Any] | None:
    """Return the JSON Schema of replies by kind of question; None if `format` asks for free text."""
    if format not in FORMATS:
        raise not_found("model.format", str(format), ["null", "schema"])
    if format == "schema" and not schemas:
        raise InputError("model.format=schema needs a JSON Schema for each kind of question under model.schemas.")
    return schemas if format == "schema" else None
