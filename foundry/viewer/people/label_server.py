"""Serves the page on which people label texts of a sweep."""

from __future__ import annotations

import threading
from typing import Any, Protocol
from urllib.parse import parse_qs, urlsplit

import msgspec

from foundry.errors import InputError
from foundry.viewer.http import LOOPBACK
from foundry.viewer.people.private import PrivateHandler, PrivateServer, read


class Desk(Protocol):
    """Where texts wait for labels."""

    def place(self, person: str) -> Any:
        """Return where a person is."""

    def label(self, person: str, item: str, label: str) -> Any:
        """Take a label and return where the person is then.

        Raises:
            InputError: it cannot be taken.
        """

    def undo(self, person: str) -> Any:
        """Take back the last label and return where the person is then.

        Raises:
            InputError: there is none.
        """


class _Label(msgspec.Struct, forbid_unknown_fields=True):
    person: str
    item: str
    label: str


class _Person(msgspec.Struct, forbid_unknown_fields=True):
    person: str


class LabelServer(PrivateServer):
    """Shows one text at a time to each person who opens its page.

    Args:
        desk: where texts wait.
        title: what is labelled, for the head of the page.
        host: the address to listen on.
        port: as `PageServer` has it.

    Attributes:
        ended: set once everybody who opened the page under a name has ended for today.

    Raises:
        InputError: the address cannot be had.
    """

    def __init__(self, desk: Desk, title: str, *, host: str = LOOPBACK, port: int | None = 0) -> None:
        self.desk, self.title = desk, title
        self.ended = threading.Event()
        self._lock = threading.Lock()
        self._there: set[str] = set()
        super().__init__(_Handler, host=host, port=port)

    def enter(self, person: str) -> Any:
        """Return where a person is, who is there from now on.

        Raises:
            InputError: the name cannot be used.
        """
        place = self.desk.place(person)
        with self._lock:
            self._there.add(person)
        return place

    def leave(self, person: str) -> int:
        """Note that a person has ended for today; returns how many others are there still."""
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
        raise InputError(f"'{path}' takes nothing.")
