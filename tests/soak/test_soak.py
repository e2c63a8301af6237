"""Runs through everything that can go wrong: a small sweep, and two hundred runs that print their figures.

Start the large one with `pytest -m soak -s`.
"""

import contextlib
import os
import re
import resource
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from commands import calls, foundry, records, started, wait_until
from faulty_server import DECIDED, TRANSIENT, Books, FaultyServer, Shares
from foundry.models.base import ChatMessage, RequestKeys
from foundry.running.build import build
from foundry.storing.store import SweepFolder
from ollama_cases import Body

SEEDS = 100
RUNS = 2 * SEEDS
SWEEP = (
    *("-m", "model=qwen3:4b,llama3.2", f"seed=0-{SEEDS - 1}", "world.agents=3", "world.steps=3"),
    *("output.dir=sweep", "analyze=false", "runner.workers=2"),
    *("model.server.retry.wait_initial_s=0.02", "model.server.retry.wait_max_s=0.5"),
    *("model.server.read_timeout_s=2", "model.server.retry.attempts=8"),
)
SMALL_SWEEP = (
    *("-m", "model=qwen3:4b", "seed=0-11", "world.agents=2", "world.steps=3", "output.dir=sweep", "analyze=false"),
    *("model.server.retry.wait_initial_s=0.01", "model.server.retry.wait_max_s=0.02", "runner.workers=1"),
    *("model.server.read_timeout_s=10.0", "model.server.retry.attempts=8"),
)
ALWAYS = {"decided": 0.02, "refused": 0.002}
DISK = "48m"
LEFT = 150_000
"""Bytes that are free on the disk that fills up."""
YEAR = 365 * 24 * 3600
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

    def duplicates(self) -> int:
        """Return how many answers were paid more than once, all in all."""
        return sum(times - 1 for times in self.server.seen().paid.values())


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


def clock_shim(folder: Path) -> Path | None:
    """Compile what moves the wall clock of a process; None where there is no compiler."""
    compiler = shutil.which("cc")
    if compiler is None:
        return None
    library = folder / "clock.so"
    source = Path(__file__).with_name("clock.c")
    subprocess.run([compiler, "-shared", "-fPIC", "-o", str(library), str(source)], check=True)
    return library


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A folder on a file system of its own where we may mount one, else a plain folder."""
    folder = tmp_path / "disk"
    folder.mkdir()
    command = ["mount", "-t", "tmpfs", "-o", f"size={DISK}", "tmpfs", str(folder)]
    mounted = shutil.which("mount") is not None and subprocess.run(command, capture_output=True).returncode == 0
    try:
        yield folder
    finally:
        if mounted:
            subprocess.run(["umount", "--lazy", str(folder)], check=True)


def say(text: str) -> None:
    sys.stdout.write(f"[{time.monotonic():6.0f} s] {text}\n")
    sys.stdout.flush()


def one_line(output: str) -> str:
    """Return the one line that says why a command ended."""
    assert "Traceback" not in output, output
    (line,) = (line for line in output.splitlines() if line.startswith("foundry: "))
    return line


def killed_again_and_again(work: Disturbed, *command: str, **environment: str) -> None:
    """Kill two workers and then the command itself, all at random moments."""
    with work.session(*command, **environment) as process:
        for _ in range(2):
            work.after(int(work.rng.integers(100, 500)), process)
            work.kill_worker(process)
        work.after(int(work.rng.integers(100, 500)), process)
        work.kill(process)


def clock_that_jumps(work: Disturbed, workspace: Path) -> bool:
    """Move the wall clock of all processes by years, ahead and back, while they work."""
    shim = clock_shim(workspace)
    if shim is None:
        return False
    offset = workspace / "offset"
    offset.write_text("0")
    environment = {"LD_PRELOAD": str(shim), "CLOCK_OFFSET_FILE": str(offset)}
    with work.session("resume", "sweep", **environment) as process:
        for years in (10, -20, 3):
            work.after(120, process)
            offset.write_text(str(years * YEAR))
        work.after(120, process)
        work.kill(process)
    return True


def full_disk(work: Disturbed, workspace: Path) -> str:
    """Fill the disk while the sweep runs; it stops with one line."""
    own = os.path.ismount(workspace)
    ballast = workspace / "ballast"
    with work.session("resume", "sweep") as process:
        if own:
            work.after(20, process)
            with contextlib.suppress(OSError), ballast.open("wb") as file:
                file.write(b"\1" * max(0, shutil.disk_usage(workspace).free - LEFT))
        else:
            most = work.cache.stat().st_size + LEFT
            resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (most, most))
        output, _ = process.communicate()
        ballast.unlink(missing_ok=True)
    assert process.returncode == 3, output
    return ("a full tmpfs: " if own else "a limit on the size of files: ") + one_line(output)


def cut_cache(work: Disturbed) -> str:
    """Cut the cache in half: nothing goes on with it; then put it back."""
    whole = work.cache.with_name("whole")
    with contextlib.closing(sqlite3.connect(work.cache)) as database:
        database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    shutil.copyfile(work.cache, whole)
    os.truncate(work.cache, work.cache.stat().st_size // 2)
    before = endings(work.folder)
    done = foundry("resume", "sweep", cwd=work.folder.parent)
    assert done.returncode == 3, done.stdout + done.stderr
    after = endings(work.folder)
    assert {run: end for run, end in after.items() if end[0] == "complete"}.keys() == {
        run for run, end in before.items() if end[0] == "complete"
    }
    for left in work.cache.parent.glob(f"{work.cache.name}-*"):
        left.unlink()
    whole.replace(work.cache)
    return one_line(done.stderr)


def other_weights(work: Disturbed) -> str:
    """Start the server anew with other weights under the same names: the sweep stops."""
    with work.session("resume", "sweep") as process:
        work.after(40, process)
        work.server.start_again(digest="ff" * 32)
        output, _ = process.communicate()
    assert process.returncode == 3, output
    work.server.start_again()
    return one_line(output)


@pytest.mark.soak
@pytest.mark.timeout(900)
def test_nothing_is_lost_or_paid_twice_whatever_goes_wrong(tmp_path: Path, small_disk: Path):
    began = time.monotonic()
    quiet = tmp_path / "quiet"
    quiet.mkdir()
    with FaultyServer(Shares(**ALWAYS)) as server:
        assert foundry(*SWEEP, cwd=quiet, OLLAMA_HOST=server.url).returncode == 3
        undisturbed_calls = server.counts.chats
    say(f"\nundisturbed: {RUNS} runs, {undisturbed_calls:,} calls, {time.monotonic() - began:.0f} s")
    with FaultyServer(Shares(transient=0.1, **ALWAYS), seed=1, each_once=True) as server:
        cache = small_disk / "outputs" / "answers.sqlite"
        work = Disturbed(server, small_disk / "sweep", cache, np.random.default_rng(1))
        killed_again_and_again(work, *SWEEP)
        say(f"three kills: {ended(work)}")
        moved = clock_that_jumps(work, tmp_path)
        say(f"a clock that jumps by years: {ended(work) if moved else 'left out, there is no compiler'}")
        say(full_disk(work, small_disk))
        say(f"a cache cut in half: {cut_cache(work)}")
        say(f"a server that comes back with other weights: {other_weights(work)}")
        killed_again_and_again(work, "resume", "sweep")
        with work.session("resume", "sweep") as process:
            output, _ = process.communicate()
        assert process.returncode == 3, output
    say(figures(work, time.monotonic() - began))
    check(work, quiet / "sweep")


def ended(work: Disturbed) -> str:
    found = [status for status, _ in endings(work.folder).values()]
    return ", ".join(f"{found.count(status)} {status}" for status in ("complete", "failed"))


def check(work: Disturbed, quiet: Path) -> None:
    """Check that all is as in the undisturbed sweep, and that nothing answered was asked again."""
    assert work.asked_again() == []
    assert work.paid_again() == {}
    assert set(TRANSIENT) <= set(work.server.books.faults)
    rough_ends, quiet_ends = endings(work.folder), endings(quiet)
    assert len(rough_ends) == RUNS
    assert all(cause for status, cause in rough_ends.values() if status == "failed")
    assert rough_ends == quiet_ends
    assert records(work.folder) == records(quiet)
    assert calls(work.folder) == calls(quiet)


def figures(work: Disturbed, seconds: float) -> str:
    """Return what happened, as lines."""
    books = work.server.books
    distinct = len(work.server.requests)
    lines = [
        f"{RUNS} runs: {ended(work)}",
        f"{books.arrived.total():,} calls for {distinct:,} questions, {books.paid.total():,} answered",
        f"{sum(books.faults[name] for name in TRANSIENT):,} transient faults:",
        *(f"  {books.faults[name]:5} {name}" for name in TRANSIENT),
        f"{sum(books.faults[name] for name in DECIDED):,} faults that are outcomes:",
        *(f"  {books.faults[name]:5} {name}" for name in (*DECIDED, "refused")),
        f"kills: {work.kills['worker']} of workers, {work.kills['main']} of the command",
        f"answers in the cache that were asked again: {len(work.asked_again())}",
        f"answers paid twice: {work.duplicates()}, of which not in flight at a kill: {work.paid_again().total()}",
        f"wall time: {seconds:.0f} s",
    ]
    return "\n".join(lines)


@pytest.mark.slow
def test_a_sweep_through_every_fault_and_a_kill_is_the_undisturbed_one(tmp_path: Path):
    quiet, rough = tmp_path / "quiet", tmp_path / "rough"
    quiet.mkdir()
    rough.mkdir()
    with FaultyServer(Shares(decided=0.1, refused=0.02)) as server:
        done = foundry(*SMALL_SWEEP, cwd=quiet, OLLAMA_HOST=server.url)
        assert done.returncode == 3 and "refused" in done.stdout + done.stderr
    with FaultyServer(Shares(decided=0.1, refused=0.02), each_once=True) as server:
        work = Disturbed(server, rough / "sweep", rough / "outputs" / "answers.sqlite", np.random.default_rng(0))
        with work.session(*SMALL_SWEEP) as process:
            work.after(60, process)
            work.kill(process)
        assert foundry("resume", "sweep", cwd=rough, OLLAMA_HOST=server.url).returncode == 3
    assert {name: server.books.faults[name] for name in TRANSIENT} == dict.fromkeys(TRANSIENT, 1)
    assert work.asked_again() == []
    assert work.paid_again() == {}
    assert {status for status, _ in endings(quiet / "sweep").values()} == {"complete", "failed"}
    for read in (endings, records, calls):
        assert read(rough / "sweep") == read(quiet / "sweep")
