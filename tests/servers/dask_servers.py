"""A real Dask scheduler and real workers, each a process of its own on this machine."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from commands import environment, wait_until
from foundry import paths

TESTS = Path(__file__).parents[1]


class Cluster:
    """A scheduler whose workers come one by one, each with scratch space of its own."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._file = folder / "scheduler.json"
        self.workers: list[subprocess.Popen[bytes]] = []
        self._logs: list[Path] = []
        options = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-show"]
        self._scheduler = self._start(["dask_scheduler", *options, "--scheduler-file", str(self._file)], "scheduler")
        wait_until(lambda: self._file.exists() and self._file.read_text().endswith("}"), "the scheduler is there")
        self.address = str(json.loads(self._file.read_text())["address"])

    def add(self, count: int, *, nanny: bool = False, path: Sequence[Path] = ()) -> None:
        """Start workers of one thread each; those with a nanny are started again when they die."""
        for _ in range(count):
            name = f"worker-{len(self.workers)}"
            scratch = self._folder / name
            scratch.mkdir()
            options = ["--nthreads", "1", "--no-dashboard", "--local-directory", str(scratch), "--name", name]
            places = os.pathsep.join(map(str, [*path, TESTS / "parts", TESTS / "runs", paths.PACKAGE.parent]))
            command = ["dask_worker", self.address, *options, *([] if nanny else ["--no-nanny"])]
            self.workers.append(self._start(command, name, {"TMPDIR": str(scratch), "PYTHONPATH": places}))
        wait_until(lambda: all("Registered to" in log.read_text() for log in self._logs[1:]), "the workers are there")

    def kill(self, pid: int) -> None:
        worker = next(worker for worker in self.workers if worker.pid == pid)
        worker.kill()
        worker.wait()

    def kill_scheduler(self) -> None:
        self._scheduler.kill()
        self._scheduler.wait()

    def close(self) -> None:
        for process in [*self.workers, self._scheduler]:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()

    def _start(self, command: Sequence[str], name: str, variables: Mapping[str, str] | None = None) -> subprocess.Popen:
        program, *options = command
        log = self._folder / f"{name}.log"
        self._logs.append(log)
        with log.open("wb") as output:
            return subprocess.Popen(
                [sys.executable, "-m", f"distributed.cli.{program}", *options],
                cwd=self._folder, env=environment(**(variables or {})), stdout=output, stderr=subprocess.STDOUT,
                start_new_session=True,
            )  # fmt: skip


@contextlib.contextmanager
def dask_cluster(folder: Path) -> Iterator[Cluster]:
    cluster = Cluster(folder)
    try:
        yield cluster
    finally:
        cluster.close()
