"""Two hundred runs through everything that can go wrong; prints its figures. Start it with `pytest -m soak -s`."""

from __future__ import annotations

import contextlib
import os
import resource
import shutil
import sqlite3
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from commands import calls, foundry, records
from disturbed import Disturbed, endings
from faulty_server import DECIDED, TRANSIENT, FaultyServer, Shares

SEEDS = 100
RUNS = 2 * SEEDS
SWEEP = (
    *("-m", "model=qwen3:4b,llama3.2", f"seed=0-{SEEDS - 1}", "world.agents=3", "world.steps=3"),
    *("output.dir=sweep", "analyze=false", "runner.workers=2"),
    *("model.server.retry.wait_initial_s=0.02", "model.server.retry.wait_max_s=0.5"),
    *("model.server.read_timeout_s=2", "model.server.retry.attempts=8"),
)
ALWAYS = {"decided": 0.02, "refused": 0.002}
DISK = "48m"
LEFT = 150_000
"""Bytes that are free on the disk that fills up."""
YEAR = 365 * 24 * 3600


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
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


class Clock:
    """Says what happened, and when."""

    def __init__(self) -> None:
        self._began = time.monotonic()

    def __call__(self, text: str) -> None:
        say(f"[{time.monotonic() - self._began:4.0f} s] {text}")


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
        tell = Clock()
        killed_again_and_again(work, *SWEEP)
        tell(f"three kills: {ended(work)}")
        moved = clock_that_jumps(work, tmp_path)
        tell(f"a clock that jumps by years: {ended(work) if moved else 'left out, there is no compiler'}")
        tell(full_disk(work, small_disk))
        tell(f"a cache cut in half: {cut_cache(work)}")
        tell(f"a server that comes back with other weights: {other_weights(work)}")
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
