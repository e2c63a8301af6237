"""Calls over HTTP, and what their answers have in common whatever API the server speaks."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime
from typing import Any

import aiohttp

from foundry.errors import TransientError
from foundry.models.base import Reply
from foundry.models.serving import HttpServing
from foundry.worlds.base import ABORTED

LONGEST_TEXT = 300
OK = 200


@dataclass(frozen=True, slots=True)
class Origin:
    """Who answered.

    Attributes:
        host: base URL of the server.
        model: name of the model on it.
        version: version of the server, or None.
        server: what to call the server in errors.
    """

    host: str
    model: str
    version: str | None = None
    server: str = "Ollama"

    def __str__(self) -> str:
        return f"{self.server} at {self.host}, model '{self.model}'"


@dataclass(frozen=True, slots=True)
class Response:
    """What a server sent back.

    Attributes:
        status: the HTTP status.
        headers: its headers, whose names have no case.
        content: the body, decompressed.
    """

    status: int
    headers: Mapping[str, str]
    content: bytes


class Transport:
    """Sends calls to one or more servers, one connection a call.

    Nothing is read from the environment: a proxy meant for the internet must see no prompt, and breaks
    calls to this machine.
    """

    def __init__(self, serving: HttpServing, ways_on: str, headers: Mapping[str, str] | None = None) -> None:
        """Take the settings; no connection is opened yet.

        Args:
            serving: time-outs and the number of connections.
            ways_on: what to do when no server answers, the end of that error.
            headers: sent with every call.
        """
        self._serving = serving
        self._ways_on = ways_on
        self._headers = {"content-type": "application/json", **(headers or {})}
        self._session: aiohttp.ClientSession | None = None
        self._opened = 0

    async def send(
        self, origin: Origin, method: str, path: str, *, read_timeout_s: float, content: bytes | None = None
    ) -> Response:
        """Return the response of the server, whatever its status.

        Raises:
            TransientError: no server answers, not in time, or not in HTTP.
        """
        timeout = aiohttp.ClientTimeout(sock_connect=self._serving.connect_timeout_s, sock_read=read_timeout_s)
        session, url = self._open_session(), f"{origin.host}{path}"
        try:
            async with session.request(method, url, data=content, timeout=timeout, allow_redirects=False) as response:
                return Response(response.status, response.headers, await response.read())
        except aiohttp.SocketTimeoutError as error:
            raise TransientError(f"{origin}: no reply within {read_timeout_s:g} s.") from error
        except aiohttp.ClientConnectorError as error:
            raise TransientError(f"{origin}: no connection ({error.os_error}). {self._ways_on}") from error
        except (aiohttp.ClientError, OSError) as error:
            raise TransientError(f"{origin}: {_cause_line(error)}. {self._ways_on}") from error

    @property
    def opened(self) -> int:
        """How many connections were opened so far."""
        return self._opened

    async def close(self) -> None:
        """Free connections; a later call opens new ones, in another event loop if need be."""
        session, self._session = self._session, None
        if session is not None:
            await session.close()

    def _open_session(self) -> aiohttp.ClientSession:
        if self._session is None:
            trace = aiohttp.TraceConfig()
            trace.on_connection_create_end.append(self._note_opened)
            # One connection a call: calls beyond the limit wait where their order and number are known.
            self._session = aiohttp.ClientSession(
                connector=aiohttp.TCPConnector(limit=self._serving.in_flight.max + 1, keepalive_timeout=60.0),
                cookie_jar=aiohttp.DummyCookieJar(),
                headers=self._headers,
                trace_configs=[trace],
                trust_env=False,
            )
        return self._session

    async def _note_opened(self, session: object, context: object, parameters: object) -> None:
        self._opened += 1


def _cause_line(error: BaseException) -> str:
    return " ".join(f"{type(error).__name__} {error}".split()).rstrip(".")


def json_object(content: bytes, origin: Origin) -> dict[str, Any]:
    """Return the JSON object in a body that came with status 200.

    Raises:
        TransientError: it is cut, or something else.
    """
    try:
        body = json.loads(content.decode("utf-8", "replace"))
    except ValueError:
        raise TransientError(f"{origin}: its reply is not JSON, or was cut ({len(content)} bytes).") from None
    if not isinstance(body, dict):
        raise TransientError(f"{origin}: its reply is not a JSON object.")
    return body


def aborted_reply(origin: Origin) -> Reply:
    """Return the reply that stands for a model that gave up."""
    return Reply(text="", ending=ABORTED, host=origin.host, server_version=origin.version)


def error_text(content: bytes) -> str:
    """Return what a refusal says in one short line, out of the JSON it may be wrapped in, twice even."""
    text = content.decode("utf-8", "replace").strip()
    while text.startswith("{"):
        try:
            said = json.loads(text)
        except ValueError:
            break
        inner = said.get("error", said.get("message"))
        if isinstance(inner, dict):
            inner = inner.get("message")
        if not isinstance(inner, str):
            break
        text = inner.strip()
    line = " ".join(text.split())
    return line if len(line) <= LONGEST_TEXT else line[:LONGEST_TEXT] + "..."


def seconds_to_wait(retry_after: str | None, now: datetime) -> float | None:
    """Return the seconds that a `Retry-After` header asks for, given as a number or as a date, else None."""
    if retry_after is None:
        return None
    try:
        seconds = float(retry_after)
    except ValueError:
        return _seconds_until(retry_after, now)
    return seconds if math.isfinite(seconds) and seconds >= 0 else None


def _seconds_until(date: str, now: datetime) -> float | None:
    try:
        moment = parsedate_to_datetime(date)
    except ValueError:
        return None
    if moment.tzinfo is None:
        moment = moment.replace(tzinfo=UTC)
    return max(0.0, (moment - now).total_seconds())
