"""Serves the page on which a person is asked, at an address that cannot be guessed."""

from __future__ import annotations

import hmac
import secrets
import threading
from collections.abc import Callable
from http import HTTPStatus
from pathlib import Path
from typing import Any, Protocol
from urllib.parse import parse_qs, unquote, urlsplit

import msgspec

from foundry.errors import InputError
from foundry.viewer.files import POLICY, inside, static_file
from foundry.viewer.http import LOOPBACK, PageHandler, PageServer, whole_number
from foundry.viewer.run_view import JSON, Resource

PAGE = Path(__file__).resolve().parent / "page"
SHARED = ("style.css", "dom.js", "icon.svg")
"""What the page takes from the one that shows records."""
PATIENCE_S = 20.0
"""How long a page that asks for what is new is kept waiting for it."""
LONGEST = 1 << 20
"""Bytes of an answer, at most."""
FAREWELL_S = 1.0
"""How long an open page is given to learn that all is over."""


class Desk(Protocol):
    """Where questions wait."""

    def standing(self, after: int = 0, patience_s: float = 0.0) -> Any:
        """Return how it stands, as soon as its `version` is past one that is known, or patience ends."""

    def agree(self) -> None:
        """Begin to show questions."""

    def answer(self, number: int, text: str) -> None:
        """Take the answer to the question that is shown.

        Raises:
            InputError: another one is, or the text is empty.
        """


class _Answer(msgspec.Struct, forbid_unknown_fields=True):
    number: int
    text: str


class PeopleServer(PageServer):
    """Shows one question at a time, once the person has agreed to be asked.

    Args:
        desk: where questions wait.
        told: what the person is told before the first question, and agrees to.
        leave: called when the person ends the sitting.
        look: called a few times a second.
        far: returns how far all is that is to be answered, 0..1, or None where only what waits is known.
        host: the address to listen on.
        port: as `PageServer` has it.

    Raises:
        InputError: the address cannot be had.
    """

    def __init__(
        self,
        desk: Desk,
        told: str,
        *,
        leave: Callable[[], None],
        look: Callable[[], None] = lambda: None,
        far: Callable[[], float | None] = lambda: None,
        host: str = LOOPBACK,
        port: int | None = 0,
    ) -> None:
        self.desk, self.told, self.leave = desk, told, leave
        self.token = secrets.token_urlsafe(16)
        self._look, self._far = look, far
        self._opened = False
        self._ended = threading.Event()
        super().__init__(_Handler, host=host, port=port)

    @property
    def url(self) -> str:
        """Where the page is; whoever knows it can answer."""
        return f"{super().url}{self.token}/"

    def service_actions(self) -> None:
        """Look whether the sitting is to end."""
        self._look()

    def standing(self, after: int) -> dict[str, Any]:
        """Return what the page shows."""
        self._opened = True
        return {**msgspec.to_builtins(self.desk.standing(after, PATIENCE_S)), "told": self.told, "far": self._far()}

    def end_told(self) -> None:
        """Note that the page knows that all is over."""
        self._ended.set()

    def farewell(self) -> None:
        """Wait a moment until an open page knows that all is over."""
        if self._opened:
            self._ended.wait(FAREWELL_S)


class _Handler(PageHandler):
    """Answers below the token alone; every other path is one that is not there."""

    server: PeopleServer

    def do_GET(self) -> None:
        self._within(self._get)

    def do_POST(self) -> None:
        self._within(self._post)

    def _within(self, answer: Callable[[str], None]) -> None:
        if not self.is_known():
            return
        token, _, path = unquote(urlsplit(self.path).path).removeprefix("/").partition("/")
        if not hmac.compare_digest(token.encode(), self.server.token.encode()):
            self.close_connection = True
            self.send_problem(HTTPStatus.NOT_FOUND, "There is nothing here: the address is in the terminal.")
            return
        self.answering(lambda: answer(path), HTTPStatus.CONFLICT)

    def _get(self, path: str) -> None:
        if path == "now":
            after = parse_qs(urlsplit(self.path).query).get("after", ["0"])[0]
            standing = self.server.standing(whole_number(after) or 0)
            self._send_json(standing)
            if standing["over"]:
                self.server.end_told()
        else:
            file = static_file(path) if path in SHARED else inside(PAGE, path or "index.html")
            self.send_file(file, path, POLICY + "; frame-ancestors 'none'")

    def _post(self, path: str) -> None:
        if "Origin" in self.headers and not self.is_own_page:
            raise InputError("Answers are sent by the page itself: open the address that is in the terminal.")
        body = self.body(LONGEST)
        if path == "agree":
            self.server.desk.agree()
        elif path == "leave":
            self.server.leave()
        elif path == "answer":
            try:
                given = msgspec.json.decode(body, type=_Answer)
            except (msgspec.DecodeError, UnicodeDecodeError) as error:
                raise InputError(f"The answer cannot be read: {error}") from error
            self.server.desk.answer(given.number, given.text)
        else:
            raise InputError(f"'{path}' takes nothing.")
        self._send_json({})

    def _send_json(self, value: Any) -> None:
        self.send(HTTPStatus.OK, Resource(msgspec.json.encode(value), JSON))
