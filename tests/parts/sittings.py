"""A sitting at the page of `foundry play`: the command in this process, a person who speaks HTTP in another thread."""

import json
import threading
import urllib.error
import urllib.request
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from subprocess import CompletedProcess
from typing import Any

import pytest

from commands import foundry
from foundry.viewer.people import people_server
from foundry.viewer.people.people_server import PeopleServer

MOVE = {"action": "move", "direction": "up", "memory": "", "reasoning": ""}
SAY = {"message": "", "reasoning": ""}


def default_reply(question: dict[str, Any]) -> str:
    return json.dumps(SAY if "message" in question["schema"]["properties"] else MOVE)


@dataclass
class Person:
    """Answers what is asked at an address, until enough is answered."""

    url: str
    most: int | None = None
    begins_at: int = 1
    reply: Callable[[dict[str, Any]], str] = default_reply
    seen: list[dict[str, Any]] = field(default_factory=list)
    far: list[float] = field(default_factory=list)

    def now(self, after: int = 0) -> dict[str, Any]:
        with urllib.request.urlopen(f"{self.url}now?after={after}") as reply:
            return dict(json.load(reply))

    def post(self, what: str, value: object = None) -> int:
        body = json.dumps(value if value is not None else {}).encode()
        try:
            with urllib.request.urlopen(urllib.request.Request(self.url + what, body)) as reply:
                return int(reply.status)
        except urllib.error.HTTPError as error:
            with error:
                return error.code

    def sit(self) -> None:
        after = 0
        while (standing := self.now(after))["waiting"] < self.begins_at and not standing["over"]:
            after = standing["version"]
        self.post("agree")
        after = 0
        while not (standing := self.now(after))["over"]:
            after = standing["version"]
            question = standing["question"]
            if question is not None and len(self.seen) == self.most:
                self.post("leave")
            elif question is not None:
                self.seen.append(question)
                self.far.append(standing["far"])
                self.post("answer", {"number": question["number"], "text": self.reply(question)})


def played(
    monkeypatch: pytest.MonkeyPatch,
    cwd: Path,
    *arguments: str,
    most: int | None = None,
    begins_at: int = 1,
    reply: Callable[[dict[str, Any]], str] = default_reply,
) -> tuple[CompletedProcess[str], Person]:
    """Run the command to its end while a person answers on its page."""
    person = Person("", most, begins_at, reply)
    thread = threading.Thread(target=person.sit)
    began = PeopleServer.__init__

    def begun(self: PeopleServer, *given: Any, **settings: Any) -> None:
        began(self, *given, **settings)
        person.url = self.url
        thread.start()

    monkeypatch.setattr(PeopleServer, "__init__", begun)
    monkeypatch.setattr(people_server, "FAREWELL_S", None)  # the person comes back for it, however late
    try:
        done = foundry("play", "--no-browser", *arguments, cwd=cwd)
    finally:
        monkeypatch.undo()
    if thread.ident is not None:
        thread.join()
    return done, person
