"""Serves the page on which a person is asked, at an address that cannot be guessed."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any, Protocol
from urllib.parse import parse_qs, urlsplit

import msgspec

from foundry.errors import InputError
from foundry.viewer.http import LOOPBACK, whole_number
from foundry.viewer.people.private import PrivateHandler, PrivateServer, read

PATIENCE_S = 20.0
"""How long a page that asks for what is new is kept waiting for it."""
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


class PeopleServer(PrivateServer):
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
        self._look, self._far = look, far
        self._opened = False
        self._ended = threading.Event()
        super().__init__(_Handler, host=host, port=port)

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


class _Handler(PrivateHandler):
    server: PeopleServer
    index = "index.html"

    def answer_get(self, path: str) -> None:
        if path != "now":
            super().answer_get(path)
            return
        after = parse_qs(urlsplit(self.path).query).get("after", ["0"])[0]
        standing = self.server.standing(whole_number(after) or 0)
        self.send_json(standing)
        if standing["over"]:
            self.server.end_told()

    def answer_post(self, path: str, body: bytes) -> Any:
        if path == "agree":
            self.server.desk.agree()
        elif path == "leave":
            self.server.leave()
        elif path == "answer":
            given = read(body, _Answer)
            self.server.desk.answer(given.number, given.text)
        else:
            raise InputError(f"'{path}' takes nothing.")
        return {}
