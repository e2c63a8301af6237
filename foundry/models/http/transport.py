"""Makes calls over HTTP, and reads the parts of responses that all APIs share."""

import functools
import json
import logging
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import aiohttp
import msgspec

from foundry.errors import RequestError, TransientError
from foundry.models.base import Reply, UnusableReply
from foundry.models.serving import HttpServing
from foundry.texts import one_line, without_surrogates
from foundry.worlds.base import ABORTED

MODEL_FAILED = ("token repeat limit", "does not match the expected", "Failed to parse input at")
"""Texts of errors (status 500) that a server sends because of the model's output: one of Ollama, two of llama.cpp."""
LONGEST_TEXT = 300
LONGEST_NAME = 300
"""foundry records at most this number of characters of a name that a server reports."""
NUMBERS = (int, float)
LARGEST_NUMBER = sys.float_info.max
LARGEST_COUNT = 2**53 - 1
"""The largest whole number that every JSON reader keeps exactly."""
LARGEST_BODY = 8 * 2**20
"""Maximum number of bytes of a decompressed body: more than a million tokens, far more than any list of models."""
OK = 200
_ORIGIN = re.compile(r"[\w ]+ at (?P<address>\S+), model '.*?': ")


@dataclass(frozen=True, slots=True)
class Origin:
    """The server and the model that a call goes to.

    Attributes:
        server: what errors call the server.
    """

    host: str
    model: str
    version: str | None = None
    server: str = "Ollama"

    def __str__(self) -> str:
        return f"{self.server} at {self.host}, model '{self.model}'"

    @staticmethod
    def cut_off(text: str) -> tuple[str, str]:
        """Return the address at the beginning of an error's text, and the text after the origin; else ("", text)."""
        match = _ORIGIN.match(text)
        return (match["address"], text[match.end() :]) if match else ("", text)


@dataclass(frozen=True, slots=True)
class Response:
    """A server's response."""

    status: int
    headers: Mapping[str, str]
    content: bytes


class Transport:
    """Sends calls to one or more servers, one connection per call.

    No settings are read from the environment: a proxy for the internet must not see prompts, and would break calls to
    this machine.
    """

    def __init__(self, serving: HttpServing, ways_on: str, headers: Mapping[str, str] | None = None) -> None:
        """Take the settings without opening a connection."""
        self._serving = serving
        self._ways_on = ways_on
        self._headers = {"content-type": "application/json", **(headers or {})}
        self._session: aiohttp.ClientSession | None = None
        self._opened = 0

    async def send(
        self, origin: Origin, method: str, path: str, *, read_timeout_s: float, content: bytes | None = None
    ) -> Response:
        """Return the response of the server, with any status.

        Raises:
            TransientError: no server answers, or the answer is late, not HTTP, or incomplete.
        """
        timeout = _timeout(read_timeout_s, self._serving.connect_timeout_s)
        session, url = self._open_session(), f"{origin.host}{path}"
        try:
            async with session.request(method, url, data=content, timeout=timeout, allow_redirects=False) as response:
                assert self._opened, "aiohttp now opens connections in another way: count them there"
                return Response(response.status, response.headers, await _body(response, origin))
        except aiohttp.ClientConnectorError as error:
            raise TransientError(f"{origin}: no connection ({error.os_error}).", advice=self._ways_on) from error
        except aiohttp.ConnectionTimeoutError as error:
            limit_s = self._serving.connect_timeout_s
            slow = f"{origin}: no connection within {limit_s:g} s."
            raise TransientError(slow, advice=self._ways_on) from error
        except TimeoutError as error:
            timed_out = f"{origin}: no complete reply within {read_timeout_s:g} s."
            raise TransientError(timed_out, late=True) from error
        except (aiohttp.ClientError, OSError) as error:
            cause = one_line(f"{type(error).__name__} {error}").rstrip(".")
            raise TransientError(f"{origin}: {cause}.", advice=self._ways_on) from error

    @property
    def opened(self) -> int:
        """Number of connections opened so far."""
        return self._opened

    async def close(self) -> None:
        """Close all connections; a later call opens new ones, also in another event loop."""
        session, self._session = self._session, None
        if session is not None:
            await session.close()

    def _open_session(self) -> aiohttp.ClientSession:
        if self._session is None:
            # One connection per call: calls beyond the limit wait in `LimitedModel`, which knows order and number.
            self._session = aiohttp.ClientSession(
                connector=_Connector(self._serving.in_flight.max + 1, self._note_opened),
                cookie_jar=aiohttp.DummyCookieJar(),
                headers=self._headers,
                trust_env=False,
            )
        return self._session

    def _note_opened(self) -> None:
        self._opened += 1


class _Connector(aiohttp.TCPConnector):
    """Counts opened connections, since counting with aiohttp's tracing would make each call a fifth slower."""

    def __init__(self, limit: int, opened: Callable[[], None]) -> None:
        super().__init__(limit=limit, keepalive_timeout=60.0)
        self._note_opened = opened

    async def _create_connection(self, *arguments: Any, **named: Any) -> Any:
        protocol = await super()._create_connection(*arguments, **named)
        self._note_opened()
        return protocol


@functools.lru_cache(maxsize=16)
def _timeout(total_s: float, connect_s: float) -> aiohttp.ClientTimeout:
    return aiohttp.ClientTimeout(total=total_s, sock_connect=connect_s)


async def _body(response: aiohttp.ClientResponse, origin: Origin) -> bytes:
    body = bytearray()
    while chunk := await response.content.readany():
        body += chunk
        if len(body) > LARGEST_BODY:
            raise TransientError(
                f"{origin}: its reply is longer than {LARGEST_BODY // 2**20} MiB, so it was not read to its end."
            )
    return bytes(body)


def schema_of(schemas: Mapping[str, Any], kind: str) -> Any:
    """Return the JSON Schema of replies to questions of this kind."""
    if kind not in schemas:
        raise RequestError(f"No schema for questions of kind '{kind}'; available: {', '.join(sorted(schemas))}.")
    return schemas[kind]


def decoded(content: bytes | str) -> Any:
    """Return the content of a JSON body; None if it is not JSON, or is nested too deep to be a reply."""
    try:
        return msgspec.json.decode(content)
    except (msgspec.DecodeError, UnicodeError, RecursionError):
        return _decoded_loosely(content)


def _decoded_loosely(content: bytes | str) -> Any:
    """Return the value of JSON with errors such as NaN or wrong UTF-8; None if even Python's tolerant reader fails."""
    text = content.decode("utf-8", "replace") if isinstance(content, bytes) else content
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return None


def json_object(content: bytes, origin: Origin) -> dict[str, Any]:
    """Return the JSON object in the body of a response with status 200."""
    body = decoded(content)
    if body is None:
        raise TransientError(f"{origin}: its reply is not JSON, or was cut ({len(content)} bytes).")
    if not isinstance(body, dict):
        raise TransientError(f"{origin}: its reply is not a JSON object.")
    return body


def count_in(body: Mapping[str, Any], key: str, origin: Origin) -> int | None:
    """Return a count of tokens from the body of a reply. If the value is no count, return None and log this once."""
    value = body.get(key)
    if value is None or (_is_number(value) and value <= LARGEST_COUNT and value == int(value)):
        return None if value is None else int(value)
    _say_unknown(origin, key)
    return None


def seconds_in(
    body: Mapping[str, Any], keys: Sequence[str], origin: Origin, *, per_s: float = 1e9
) -> list[float] | None:
    """Return durations in seconds; a missing duration is 0. If a value is no number, return None and log this once."""
    for key in keys:
        if not _is_number(body.get(key, 0)):
            _say_unknown(origin, key)
            return None
    return [float(body.get(key, 0)) / per_s for key in keys]


def _is_number(value: Any) -> bool:
    """Return whether a value is a number of at least 0 that every JSON reader reads; true and NaN do not count."""
    return isinstance(value, NUMBERS) and not isinstance(value, bool) and 0 <= value <= LARGEST_NUMBER


@functools.lru_cache(maxsize=256)  # each worker reports this once
def _say_unknown(origin: Origin, key: str) -> None:
    logging.getLogger("foundry").warning(
        "%s: '%s' in its replies is not a number, and is recorded as unknown.", origin, key
    )


def name_in(value: Any) -> str | None:
    """Return a name that a server sent; None if it is empty or not a text."""
    return without_surrogates(value[:LONGEST_NAME]) if isinstance(value, str) and value else None


def names_in(value: Any) -> tuple[str, ...]:
    """Return the texts in a list that a server sent; empty if the value is not a list."""
    return tuple(name for name in value if isinstance(name, str)) if isinstance(value, list) else ()


def length_in(value: Any) -> int | None:
    """Return a length or a number that a server sent, such as a context in tokens; None if it is not positive."""
    return value if isinstance(value, int) and not isinstance(value, bool) and 0 < value <= LARGEST_COUNT else None


def aborted_reply(origin: Origin) -> Reply:
    """Return the empty reply for a call that the model aborted."""
    return Reply(text="", ending=ABORTED, host=origin.host, server_version=origin.version)


def model_failure(origin: Origin, line: str) -> UnusableReply | None:
    """Return the error for a call that failed because of the output of the model; None for any other cause."""
    failed = any(part in line for part in MODEL_FAILED)
    return UnusableReply(line, aborted_reply(origin)) if failed else None


def error_text(content: bytes) -> str:
    """Return the message of a server's error in one short line, taken out of up to two levels of JSON."""
    text = content.decode("utf-8", "replace").strip()
    while text.startswith("{"):
        body = decoded(text)
        if not isinstance(body, dict):
            break
        inner = body.get("error", body.get("message"))
        if isinstance(inner, dict):
            inner = inner.get("message")
        if not isinstance(inner, str):
            break
        text = inner.strip()
    line = without_surrogates(one_line(text))
    return line if len(line) <= LONGEST_TEXT else line[:LONGEST_TEXT] + "..."
