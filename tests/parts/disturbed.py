"""Disturbs a sweep that runs in processes of its own, and keeps count of what may be asked again because of it."""

from __future__ import annotations

import base64
import contextlib
import os
import re
import signal
import sqlite3
import subprocess
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from commands import started, wait_until
from faulty_server import Books, FaultyServer
from foundry.models.base import ChatMessage, RequestKeys
from foundry.running.build import build
from foundry.storing.store import SweepFolder
from ollama_cases import Body

_ADDRESS = re.compile(r"http://127\.0\.0\.1:\d+")


@dataclass
class Disturbed:
    """A sweep and what is done to it."""

    server: FaultyServer
    folder: Path
    cache: Path
    rng: np.random.Generator
    excused: Counter[bytes] = field(default_factory=Counter)
    settled: dict[bytes, int] = field(default_factory=dict)
    kills: Counter[str] = field(default_factory=Counter)
    _keys: dict[str, RequestKeys] = field(default_factory=dict)
    _known: dict[bytes, str] = field(default_factory=dict)

    @contextlib.contextmanager
    def session(self, *arguments: str, **environment: str) -> Iterator[subprocess.Popen[str]]:
        """Start a command; whatever it started is gone at the end, and the books are balanced."""
        with started(*arguments, cwd=self.folder.parent, OLLAMA_HOST=self.server.url, **environment) as process:
            yield process
        wait_until(lambda: not _group(process.pid), "all its processes are gone")
        wait_until(lambda: not +self.server.seen().open, "the server works on nothing")
        self.balance()

    def after(self, calls: int, process: subprocess.Popen[str]) -> None:
        """Wait until so many further calls came in, or the command ended."""
        goal = self.server.counts.chats + calls
        wait_until(lambda: self.server.counts.chats >= goal or process.poll() is not None, f"{calls} calls came in")

    def kill_worker(self, process: subprocess.Popen[str]) -> None:
        """Kill a worker in the middle of its work; what was in flight then, of all of them, may be paid again."""
        reports = SweepFolder.open(self.folder).progress().values()
        working = [report["pid"] for report in reports if report["open"] and _parent(report["pid"]) == process.pid]
        if not working:
            return
        os.kill(int(self.rng.choice(working)), signal.SIGKILL)
        self.kills["worker"] += 1
        self.excuse(self.server.seen())

    def kill(self, process: subprocess.Popen[str]) -> None:
        """Kill the command itself; its workers notice."""
        process.kill()
        process.wait()
        self.kills["main"] += 1

    def excuse(self, books: Books) -> None:
        """Let calls be paid once more whose answers are not in the cache, or were not when the books were read."""
        cached = self.cached()
        for call in books.paid.keys() | (+books.open).keys():
            if self.key(call) not in cached:
                self.excused[call] = max(self.excused[call], books.paid[call] + books.open[call])

    def balance(self) -> None:
        """Note what is in the cache, while nothing runs: none of it may ever be asked again."""
        books = self.server.seen()
        self.excuse(books)
        cached = self.cached()
        for call, times in books.arrived.items():
            if self.key(call) in cached:
                self.settled.setdefault(call, times)

    def cached(self) -> set[str]:
        """Return the keys of the answers in the cache."""
        database = sqlite3.connect(f"file:{self.cache}?mode=ro", uri=True, timeout=3600)
        with contextlib.closing(database):
            return {key for (key,) in database.execute("SELECT key FROM answers")}

    def key(self, call: bytes) -> str:
        """Return the key in the cache of a call."""
        if call not in self._known:
            for known, body in self.server.requests.items():
                self._known.setdefault(known, self._key(body))
        return self._known[call]

    def _key(self, body: Body) -> str:
        if not self._keys:
            folder = SweepFolder.open(self.folder)
            digests = {model["name"]: model["digest"] for model in folder.models}
            for condition in folder.sweep.conditions:
                model = build(condition.config["model"])
                self._keys[model.name] = RequestKeys(model, digests[model.name])
        return self._keys[body["model"]].key([_message(one) for one in body["messages"]], body["options"]["seed"])

    def asked_again(self) -> list[bytes]:
        """Return the calls that were made although their answers were in the cache."""
        arrived = self.server.seen().arrived
        return [call for call, times in self.settled.items() if arrived[call] > times]

    def paid_again(self) -> Counter[bytes]:
        """Return how often calls were paid beyond once, kills excused."""
        paid = self.server.seen().paid
        return Counter({call: times - 1 - self.excused[call] for call, times in paid.items()}) & paid

    def duplicates(self) -> int:
        """Return how many answers were paid more than once, all in all."""
        return sum(times - 1 for times in self.server.seen().paid.values())


def _message(message: Mapping[str, str]) -> ChatMessage:
    images = tuple(base64.b64decode(image) for image in message.get("images", ()))
    return ChatMessage(message["role"], message["content"], images)


def _stat(pid: int) -> list[str]:
    """Return state, parent and group of a process; nothing when it is gone."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[:3]
    except (FileNotFoundError, ProcessLookupError):
        return []


def _parent(pid: int) -> int:
    found = _stat(pid)
    return int(found[1]) if found else 0


def _group(pid: int) -> list[int]:
    """Return the processes of a group that are alive."""
    everyone = (int(entry.name) for entry in Path("/proc").iterdir() if entry.name.isdigit())
    stats = ((one, _stat(one)) for one in everyone)
    return [one for one, found in stats if found and found[0] != "Z" and int(found[2]) == pid]


def endings(folder: Path) -> dict[str, tuple[str | None, str | None]]:
    """Return how every run ended and its cause, without the addresses of servers."""
    summaries = {run.id: run.summary() for run in SweepFolder.open(folder).runs()}
    return {
        run: (one.status, _ADDRESS.sub("", one.error or "")) if one else (None, None) for run, one in summaries.items()
    }
