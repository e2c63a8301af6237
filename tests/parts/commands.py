"""Starts the command `foundry` in a process of its own, and reads what it left behind."""

import contextlib
import io
import os
import re
import signal
import sqlite3
import subprocess
import sys
import threading
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec

from foundry.cli import run
from foundry.storing.store import SweepFolder
from traces import no_traces

SMALL = ("world.agents=4", "world.steps=4", "analyze=false")


def environment(**changes: str) -> dict[str, str]:
    return {**os.environ, **changes}


def foundry(*arguments: str, cwd: Path, **changes: str) -> subprocess.CompletedProcess[str]:
    """Run the command to its end, in this process, as if it had been started in `cwd` with these variables."""
    out, error = io.StringIO(), io.StringIO()
    with no_traces(), contextlib.chdir(cwd), contextlib.redirect_stdout(out), contextlib.redirect_stderr(error):
        os.environ.update(changes)
        code = run(arguments)
    return subprocess.CompletedProcess(arguments, code, out.getvalue(), error.getvalue())


def succeeds(*arguments: str, cwd: Path, **changes: str) -> subprocess.CompletedProcess[str]:
    done = foundry(*arguments, cwd=cwd, **changes)
    assert done.returncode == 0, done.stdout + done.stderr
    return done


def refusal(*arguments: str, cwd: Path, **changes: str) -> str:
    """Run a command that must refuse what it is asked; return its one line on the standard error."""
    done = foundry(*arguments, cwd=cwd, **changes)
    assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stdout + done.stderr
    return done.stderr


@contextlib.contextmanager
def started(*arguments: str, cwd: Path, **changes: str) -> Iterator[subprocess.Popen[str]]:
    """Start the command in a process group of its own; whatever is left of it at the end is killed."""
    with subprocess.Popen(
        [sys.executable, "-m", "foundry", *arguments],
        cwd=cwd, env=environment(**changes), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        start_new_session=True,
    ) as process:  # fmt: skip
        try:
            yield process
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)


def wait_until(condition: Callable[[], bool], what: str, process: subprocess.Popen[str] | None = None) -> None:
    """Wait for something that another process does, as long as pytest lets a test run."""
    never = threading.Event()
    while not condition():
        if process is not None and process.poll() is not None and not condition():
            raise AssertionError(f"ended with {process.returncode} before {what}:\n{process.communicate()[0]}")
        never.wait(0.01)


def answers(url: str) -> bool:
    """Return whether a server answers at an address."""
    try:
        with urllib.request.urlopen(url) as response:
            return bool(response.status == 200)
    except OSError:
        return False


def kill(pid: int) -> None:
    """Kill a process; returns once the system has closed its connections, where it says so."""
    os.kill(pid, signal.SIGKILL)
    wait_until(lambda: is_dead(pid), f"process {pid} is dead")


def is_dead(pid: int) -> bool:
    """Return whether a process and all its threads ended, if its parent has not asked for its exit code yet."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    except (FileNotFoundError, ProcessLookupError):
        return True
    state, threads = fields[0], int(fields[17])
    return state in "ZX" and threads <= 1


def cached_answers(path: Path) -> int:
    if not path.exists():
        return 0
    database = sqlite3.connect(path)
    try:
        return int(database.execute("SELECT count(*) FROM answers").fetchone()[0])
    except sqlite3.OperationalError:
        return 0
    finally:
        database.close()


def records(folder: Path) -> dict[str, dict[str, bytes]]:
    names = ("steps.jsonl", "messages.jsonl")
    return {run.id: {name: (run.path / name).read_bytes() for name in names} for run in SweepFolder.open(folder).runs()}


def calls(folder: Path) -> dict[str, list[dict[str, Any]]]:
    """Return every run's calls, without what may differ between equal runs: times, tries, host, cached."""
    fleeting = ("timings", "attempts", "host", "cached")
    return {
        run.id: [
            {key: value for key, value in msgspec.to_builtins(call).items() if key not in fleeting}
            for call in run.calls()
        ]
        for run in SweepFolder.open(folder).runs()
    }


def statuses(folder: Path) -> list[str | None]:
    return [summary.status if (summary := run.summary()) else None for run in SweepFolder.open(folder).runs()]


def is_stopping(folder: Path) -> bool:
    return any(folder.glob("progress/*.stop"))


def shared(folder: Path) -> list[int]:
    """Return how many calls each worker of a sweep may have in flight, once one of them divides the limit."""
    if not (folder / "sweep.yaml").exists():
        return []
    reports = SweepFolder.open(folder).progress().values()
    parts = [part for report in reports for part in report.get("limits", {}).values()]
    return [part["allowed"] for part in parts] if any(part["shares"] for part in parts) else []


def sessions(folder: Path) -> set[str]:
    """Return the sessions whose workers report of a sweep."""
    return {name.partition("-")[0] for name in SweepFolder.open(folder).progress()}


def sweep_folder(output: str) -> Path:
    """Return the folder that a finished command said it wrote."""
    match = re.search(r"runs? in (\S+)", output)
    assert match, output
    return Path(match[1])
