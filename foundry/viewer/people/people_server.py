"""Serves the page where a person answers questions, at an unguessable address."""

import threading
from collections.abc import Callable
from typing import Any, Protocol
from urllib.parse import parse_qs, urlsplit

import msgspec

from foundry.errors import InputError
from foundry.viewer.http import LOOPBACK, whole_number
from foundry.viewer.people.private import PrivateHandler, PrivateServer, read

PATIENCE_S = 20.0
"""Time after which a waiting request of the page gets the present state, seconds."""
FAREWELL_S = 1.0
"""Seconds for which the server waits after a session, so that an open page can get the final state."""


class Desk(Protocol):
    """Gives the person questions, one by one."""

    def standing(self, after: int = 0, patience_s: float = 0.0) -> Any:
        """Wait at most `patience_s` seconds until the `version` of the state is above `after`; return the state."""

    def agree(self) -> None:
        """Record that the person has agreed, and show the first question."""

    def answer(self, number: int, text: str) -> None:
        """Take the answer to the question on display; raise InputError if it answers another question."""


class _Answer(msgspec.Struct, forbid_unknown_fields=True):
    number: int
    text: str


class PeopleServer(PrivateServer):
    """Shows one question at a time, after the person has agreed.

    Args:
        desk: queue of questions.
        terms: text that the person must agree to before the first question.
        leave: function that is called when the person ends the session.
        look: function that is called a few times per second.
        far: function that returns the finished share of the session, 0..1; None if it is unknown.
        host, port: see `PageServer`.
    """

    def __init__(
        self,
        desk: Desk,
        terms: str,
        *,
        leave: Callable[[], None],
        look: Callable[[], None] = lambda: None,
        far: Callable[[], float | None] = lambda: None,
        host: str = LOOPBACK,
        port: int | None = 0,
    ) -> None:
        self.desk, self.told, self.leave = desk, terms, leave
        self._look, self._far = look, far
        self._opened = False
        self._ended = threading.Event()
        super().__init__(_Handler, host=host, port=port)

    def service_actions(self) -> None:
        """Call the function `look`, which may end the session; this happens several times per second."""
        self._look()

    def standing(self, after: int) -> dict[str, Any]:
        """Return the data that the page shows now, such as the pending question."""
        self._opened = True
        return {**msgspec.to_builtins(self.desk.standing(after, PATIENCE_S)), "told": self.told, "far": self._far()}

    def end_told(self) -> None:
        """Record that the page knows that the session is over."""
        self._ended.set()

    def farewell(self) -> None:
        """Wait up to a second, until an open page knows that the session is over."""
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
            raise InputError(f"The address '{path}' accepts no data.")
        return {}
