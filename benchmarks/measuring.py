"""Shared parts of the benchmarks: clocks, a test server in its own process, sweeps in this process, Markdown tables."""

import argparse
import contextlib
import os
import platform
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from foundry.composing.compose import compose
from foundry.composing.preflight import check
from foundry.expansion import expand
from foundry.records import RunSummary
from foundry.running.build import build
from foundry.running.local import SweepJob
from foundry.storing.store import SweepFolder

ROOT = Path(__file__).resolve().parent.parent
MEMORY = Path("/dev/shm")


@dataclass(frozen=True)
class Cost:
    """Wall-clock time and CPU time, seconds."""

    wall_s: float
    cpu_s: float


class Stopwatch:
    """Measures the time of this process since the stopwatch was made."""

    def __init__(self) -> None:
        self._wall, self._cpu = time.perf_counter(), time.process_time()

    def cost(self) -> Cost:
        """Return the cost so far."""
        return Cost(time.perf_counter() - self._wall, time.process_time() - self._cpu)


@dataclass(frozen=True)
class Swept:
    """A sweep that ran in this process.

    Attributes:
        summaries: summaries of its runs, in the order of their starts.
        whole: cost of composing, checking, writing the sweep's folder, and the runs.
    """

    folder: SweepFolder
    summaries: tuple[RunSummary, ...]
    running: Cost
    whole: Cost

    @property
    def calls(self) -> int:
        """Model calls of all runs."""
        return sum(summary.counts.calls for summary in self.summaries)

    @property
    def cached(self) -> int:
        """Calls that the answer cache answered."""
        return sum(summary.counts.cached for summary in self.summaries)


@dataclass(frozen=True)
class Server:
    """The test server, in its own process on the same machine."""

    url: str
    pid: int

    def cpu_s(self) -> float:
        """Return the CPU seconds of the server so far; nan if the system has no /proc."""
        stat = Path(f"/proc/{self.pid}/stat")
        if not stat.exists():
            return float("nan")
        user, system = stat.read_text().rpartition(")")[2].split()[11:13]
        return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


def cost_of(work: Callable[[], object]) -> Cost:
    """Return the cost of the work in this process."""
    watch = Stopwatch()
    work()
    return watch.cost()


def cost_of_command(*arguments: str) -> Cost:
    """Return the cost of a `foundry` command in its own process, from start to exit."""
    wall, before = time.perf_counter(), os.times()
    subprocess.run([sys.executable, "-m", "foundry", *arguments], check=True, stdout=subprocess.DEVNULL)
    after = os.times()
    user_s = after.children_user - before.children_user
    system_s = after.children_system - before.children_system
    return Cost(time.perf_counter() - wall, user_s + system_s)


def fastest(costs: Sequence[Cost]) -> Cost:
    """Return the cost with the shortest wall-clock time, because other work on the machine can only lengthen it."""
    return min(costs, key=lambda cost: cost.wall_s)


def run_sweep(folder: Path, *overrides: str, cache: str | None = None) -> Swept:
    """Run a sweep as the command does, without a display; the cache is beside its folder unless you name another."""
    watch = Stopwatch()
    answers = cache or str(folder.parent / "answers.sqlite")
    composed = compose(["-m", *overrides, f"output.dir={folder}", f"cache.path='{answers}'"])
    assert composed is not None
    sweep = expand(composed.asked, composed.conditions)
    infos = check(sweep)
    opened = SweepFolder.create(folder, sweep, dict(composed.settings), [])
    job = SweepJob(opened, infos, composed.settings["cache"]["path"], frame_every=0)
    runner = build(composed.settings["runner"])
    running = cost_of(lambda: runner.run(job))
    whole = watch.cost()
    return Swept(opened, _summaries(opened), running, whole)


def _summaries(folder: SweepFolder) -> tuple[RunSummary, ...]:
    summaries = [summary for run in folder.runs() if (summary := run.summary())]
    failures = [summary.error for summary in summaries if summary.status != "complete"]
    if failures or len(summaries) != len(folder.runs()):
        raise RuntimeError(f"Not all {len(folder.runs())} runs completed: {failures[:1]}")
    return tuple(sorted(summaries, key=lambda summary: summary.started))


@contextlib.contextmanager
def server(latency_s: float) -> Iterator[Server]:
    """Start the test server; it answers every call after `latency_s`."""
    script = ROOT / "tests" / "servers" / "ollama_server.py"
    with _printing_url(script, "--port", "0", "--latency", f"{latency_s}") as to:
        yield to


@contextlib.contextmanager
def serving(script: str, *arguments: str) -> Iterator[Server]:
    """Start a server script of this folder in its own process."""
    with _printing_url(Path(__file__).with_name(script), *arguments) as to:
        yield to


@contextlib.contextmanager
def _printing_url(script: Path, *arguments: str) -> Iterator[Server]:
    """Start a script that prints the URL it serves, and end it afterwards."""
    command = [sys.executable, str(script), *arguments]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            url = process.stdout.readline().strip()
            if not url:
                raise RuntimeError("The test server did not start.")
            yield Server(url, process.pid)
        finally:
            process.terminate()


def await_health(process: subprocess.Popen[bytes], url: str) -> None:
    """Wait until a started server answers at its `/health`.

    Raises:
        RuntimeError: the server ended before.
    """
    while process.poll() is None:
        with contextlib.suppress(OSError), urllib.request.urlopen(f"{url}/health") as answer:
            if answer.status == 200:
                return
        time.sleep(0.1)
    raise RuntimeError("the server does not start")


@contextlib.contextmanager
def scratch(*, in_memory: bool = False) -> Iterator[Path]:
    """Make a temporary folder, in memory if the system has a file system in memory."""
    place = MEMORY if in_memory and MEMORY.is_dir() else None
    with tempfile.TemporaryDirectory(prefix="foundry-bench-", dir=place) as folder:
        yield Path(folder)


def most_runs(description: str | None) -> int:
    """Return the number of runs of the largest sweep, from the command line."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--most", type=int, default=1_000, help="number of runs of the largest sweep (default 1,000)")
    return int(parser.parse_args().most)


def at_most(value: float, target: float, unit: str) -> tuple[str, str]:
    """Return the target in words, and whether the value meets it."""
    return f"at most {target:,g} {unit}".strip(), "met" if value <= target else "missed"


def at_least(value: float, target: float, unit: str) -> tuple[str, str]:
    """Return the target in words, and whether the value meets it."""
    return f"at least {target:,g} {unit}".strip(), "met" if value >= target else "missed"


def print_title(title: str, *notes: str) -> None:
    """Print the title of a measurement, the machine, and the method."""
    machine = f"{os.cpu_count()} cores ({platform.machine()}), {platform.system()}, Python {platform.python_version()}"
    load = f"load {os.getloadavg()[0]:.1f} before" if hasattr(os, "getloadavg") else "load unknown"
    print(f"### {title}\n\n{machine}; {load}. {' '.join(notes)}\n", flush=True)


def print_table(columns: Sequence[str], rows: Sequence[Sequence[Any]]) -> None:
    """Print a Markdown table with padded columns, which is also readable in a terminal."""
    cells = [list(columns), *([str(cell) for cell in row] for row in rows)]
    widths = [max(len(row[index]) for row in cells) for index in range(len(columns))]
    lines = [" | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in cells]
    lines.insert(1, " | ".join("-" * width for width in widths))
    print("".join(f"| {line} |\n" for line in lines), flush=True)
