"""Serves the page where people label texts of a sweep."""

import threading
from typing import Any, Protocol
from urllib.parse import parse_qs, urlsplit

import msgspec

from foundry.errors import InputError
from foundry.viewer.http import LOOPBACK
from foundry.viewer.people.private import PrivateHandler, PrivateServer, read


class Desk(Protocol):
    """Gives each person texts to label, one by one. Each method returns the person's progress, or raises InputError."""

    def place(self, person: str) -> Any:
        """Return the text that a person labels next."""

    def label(self, person: str, item: str, label: str) -> Any:
        """Take the label that a person gives to a text."""

    def undo(self, person: str) -> Any:
        """Remove the last label of a person."""


class _Label(msgspec.Struct, forbid_unknown_fields=True):
    person: str
    item: str
    label: str


class _Person(msgspec.Struct, forbid_unknown_fields=True):
    person: str


class LabelServer(PrivateServer):
    """Shows one text at a time to each person who opens its page.

    Args:
        desk: queue of texts.
        title: heading of the page.
        host, port: see `PageServer`.

    Attributes:
        ended: event that is set when all people who entered a name on the page have ended for today.
    """

    def __init__(self, desk: Desk, title: str, *, host: str = LOOPBACK, port: int | None = 0) -> None:
        self.desk, self.title = desk, title
        self.ended = threading.Event()
        self._lock = threading.Lock()
        self._there: set[str] = set()
        super().__init__(_Handler, host=host, port=port)

    def enter(self, person: str) -> Any:
        """Record that a person is present, and return the person's progress."""
        place = self.desk.place(person)
        with self._lock:
            self._there.add(person)
        return place

    def leave(self, person: str) -> int:
        """Record that a person has ended for today, and return the number of people who are still present."""
        with self._lock:
            self._there.discard(person)
            if not self._there:
                self.ended.set()
            return len(self._there)


class _Handler(PrivateHandler):
    server: LabelServer
    index = "label.html"

    def answer_get(self, path: str) -> None:
        if path == "title":
            self.send_json({"title": self.server.title})
        elif path == "place":
            self.send_json(self.server.enter(parse_qs(urlsplit(self.path).query).get("person", [""])[0]))
        else:
            super().answer_get(path)

    def answer_post(self, path: str, body: bytes) -> Any:
        if path == "label":
            given = read(body, _Label)
            return self.server.desk.label(given.person, given.item, given.label)
        if path == "undo":
            return self.server.desk.undo(read(body, _Person).person)
        if path == "end":
            return {"others": self.server.leave(read(body, _Person).person)}
        raise InputError(f"The address '{path}' accepts no data.")
