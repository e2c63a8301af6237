"""Runs each worker in a process of its own, and replaces workers whose process dies."""

import itertools
import logging
import os
from collections import Counter
from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import replace

from foundry.errors import FoundryError
from foundry.running.lane import LaneSpec, run_lane, summarise
from foundry.running.lane_process import LaneProcess, WorkerDied
from foundry.storing.run_writer import write_run_summary
from foundry.storing.store import storing

MAX_DEATHS = 2
"""A run fails if this number of workers have died while each of them was playing only this run."""
MAX_IDLE_DEATHS = 5
"""If more than this number of workers died without an open run, the sweep stops."""
POLL_S = 0.25


class Abandoned(FoundryError):
    """The command that started a worker and waits for its result has ended."""


class Lanes:
    """Worker processes that share the runs of a sweep."""

    def __init__(self, spec: LaneSpec, workers: int, abandoned: Callable[[], bool] = lambda: False) -> None:
        self._spec = replace(spec, parent=os.getpid(), workers=max(spec.workers, workers))
        self._workers = workers
        self._abandoned = abandoned
        self._numbers = itertools.count()
        self._processes: dict[Future[str | None], LaneProcess] = {}
        self._specs: dict[Future[str | None], LaneSpec] = {}
        self._deaths: Counter[str] = Counter()
        self._idle_deaths = 0
        self._said: set[str] = set()

    def run(self) -> str | None:
        """Wait until all runs have ended or the sweep stops; return the cause that must end the sweep, or None."""
        fatal: str | None = None
        try:
            for _ in range(self._workers):
                self._start(())
            while self._processes:
                if self._abandoned():
                    raise Abandoned("The command that waits for these runs has gone.")
                done, _ = wait(self._processes, timeout=POLL_S, return_when=FIRST_COMPLETED)
                for future in done:
                    fatal = self._collect(future) or fatal
                    if fatal:
                        stop_file = self._spec.folder.stop_file(self._spec.session)
                        with storing(stop_file):
                            stop_file.touch()
                self._say()
        finally:
            for process in self._processes.values():
                process.kill()
        return fatal

    def _say(self) -> None:
        for name, report in self._spec.folder.progress().items():
            for line in report.get("notes", ()):
                if self._spec.is_of_session(name) and line not in self._said:
                    self._said.add(line)
                    logging.getLogger("foundry").warning("%s", line)

    def _start(self, suspects: tuple[str, ...]) -> None:
        spec = replace(self._spec, name=f"{self._spec.name}-{next(self._numbers)}", suspects=suspects)
        process = LaneProcess(run_lane, spec)
        self._processes[process.ended], self._specs[process.ended] = process, spec

    def _collect(self, future: Future[str | None]) -> str | None:
        """Return the result of a worker that ended; if it died, start another worker and return None."""
        spec = self._specs.pop(future)
        del self._processes[future]
        try:
            return future.result()
        except WorkerDied:
            if not self._spec.folder.stop_asked(self._spec.session):
                self._start(self._suspects(spec))
            return None

    def _suspects(self, spec: LaneSpec) -> tuple[str, ...]:
        """Return the ids of the runs that a dead worker had open.

        A run fails if it was the only open run of too many dead workers.
        """
        opened: list[str] = self._spec.folder.progress().get(spec.name, {}).get("open", [])
        if not opened:
            self._idle_deaths += 1
            if self._idle_deaths > MAX_IDLE_DEATHS:
                raise FoundryError(f"Worker processes died {self._idle_deaths} times before they began a run.")
        if len(opened) == 1:
            self._deaths[opened[0]] += 1
            if self._deaths[opened[0]] >= MAX_DEATHS:
                self._give_up(opened[0])
                return ()
        return tuple(opened)

    def _give_up(self, run: str) -> None:
        folder = next(folder for folder in self._spec.folder.runs() if folder.id == run)
        error = FoundryError(
            f"The worker process died {self._deaths[run]} times while it had only this run open: "
            "it was killed, or ran out of memory."
        )
        summary = summarise(folder, self._spec.infos, None, started="", seconds=0.0, error=error)
        write_run_summary(folder, summary)
