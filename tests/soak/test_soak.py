"""A sweep through every fault of a server, a clock that jumps and a kill."""

import contextlib
import re
import shutil
import sqlite3
import subprocess
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from commands import calls, foundry, records, started, wait_until
from faulty_server import TRANSIENT, Books, FaultyServer, Shares
from foundry.models.base import ChatMessage, RequestKeys
from foundry.running.build import build
from foundry.storing.store import SweepFolder
from ollama_cases import Body

SWEEP = (
    *("-m", "model=qwen3:4b", "seed=0-11", "world.agents=2", "world.steps=3", "output.dir=sweep", "analyze=false"),
    *("model.server.retry.wait_initial_s=0.01", "model.server.retry.wait_max_s=0.02", "runner.workers=1"),
    *("model.server.read_timeout_s=10.0", "model.server.retry.attempts=8"),
)
YEAR = 365 * 24 * 3600
_ADDRESS = re.compile(r"http://127\.0\.0\.1:\d+")


@dataclass
class Disturbed:
    """A sweep and what is done to it."""

    server: FaultyServer
    folder: Path
    cache: Path
    excused: Counter[bytes] = field(default_factory=Counter)
    settled: dict[bytes, int] = field(default_factory=dict)
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
        goal = self.server.counts.chats + calls
        wait_until(lambda: self.server.counts.chats >= goal or process.poll() is not None, f"{calls} calls came in")

    def kill(self, process: subprocess.Popen[str]) -> None:
        process.kill()
        process.wait()

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
        return self._keys[body["model"]].key(
            [ChatMessage(one["role"], one["content"]) for one in body["messages"]], body["options"]["seed"]
        )

    def asked_again(self) -> list[bytes]:
        """Return the calls that were made although their answers were in the cache."""
        arrived = self.server.seen().arrived
        return [call for call, times in self.settled.items() if arrived[call] > times]

    def paid_again(self) -> Counter[bytes]:
        """Return how often calls were paid beyond once, kills excused."""
        paid = self.server.seen().paid
        return Counter({call: times - 1 - self.excused[call] for call, times in paid.items()}) & paid


def _group(pid: int) -> list[int]:
    """Return the processes of a group that are alive."""
    found = []
    for entry in (path for path in Path("/proc").iterdir() if path.name.isdigit()):
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):
            state, _, group = (entry / "stat").read_text().rpartition(")")[2].split()[:3]
            found += [int(entry.name)] if state != "Z" and int(group) == pid else []
    return found


def endings(folder: Path) -> dict[str, tuple[str | None, str | None]]:
    """Return how every run ended and its cause, without the addresses of servers."""
    summaries = {run.id: run.summary() for run in SweepFolder.open(folder).runs()}
    return {
        run: (run_summary.status, _ADDRESS.sub("", run_summary.error or "")) if run_summary else (None, None)
        for run, run_summary in summaries.items()
    }


def moving_clock(folder: Path) -> dict[str, str]:
    """Return the environment in which the file `offset` moves the wall clock, in seconds; none without a compiler."""
    compiler = shutil.which("cc")
    (folder / "offset").write_text("0")
    if compiler is None:
        return {}
    command = [compiler, "-shared", "-fPIC", "-o", folder / "clock.so", Path(__file__).with_name("clock.c")]
    subprocess.run(command, check=True)
    return {"LD_PRELOAD": str(folder / "clock.so"), "CLOCK_OFFSET_FILE": str(folder / "offset")}


@pytest.mark.slow
def test_a_sweep_through_every_fault_a_clock_that_jumps_and_a_kill_is_the_undisturbed_one(tmp_path: Path):
    quiet, rough = tmp_path / "quiet", tmp_path / "rough"
    quiet.mkdir()
    rough.mkdir()
    with FaultyServer(Shares(decided=0.1, refused=0.02)) as server:
        done = foundry(*SWEEP, cwd=quiet, OLLAMA_HOST=server.url)
        assert done.returncode == 3 and "refused" in done.stdout + done.stderr
    with FaultyServer(Shares(decided=0.1, refused=0.02), each_once=True) as server:
        work = Disturbed(server, rough / "sweep", rough / "outputs" / "answers.sqlite")
        with work.session(*SWEEP, **moving_clock(tmp_path)) as process:
            for years in (10, -20):
                work.after(20, process)
                (tmp_path / "offset").write_text(str(years * YEAR))
            work.after(20, process)
            work.kill(process)
        assert foundry("resume", "sweep", cwd=rough, OLLAMA_HOST=server.url).returncode == 3
    assert {name: server.books.faults[name] for name in TRANSIENT} == dict.fromkeys(TRANSIENT, 1)
    assert work.asked_again() == []
    assert work.paid_again() == {}
    assert {status for status, _ in endings(quiet / "sweep").values()} == {"complete", "failed"}
    for read in (endings, records, calls):
        assert read(rough / "sweep") == read(quiet / "sweep")
