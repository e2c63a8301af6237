"""Runs sweeps from Python, for example in a notebook, as the command `foundry` does, but without its output."""

import asyncio
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from foundry.composing.compose import compose
from foundry.composing.preparing import checked, job_of
from foundry.errors import InputError
from foundry.running.local import SweepJob
from foundry.storing.store import SweepFolder

T = TypeVar("T")


@dataclass(frozen=True)
class Ran:
    """The result of a sweep, or of one run.

    Attributes:
        path: folder of the sweep, for `foundry.load` and `foundry.analyze`.
        complete: number of complete runs.
        failed: one line with the error of each run that is not complete.
        notes: remarks on the worlds, and on worlds that were left out, one line each.
    """

    path: Path
    complete: int
    failed: tuple[str, ...]
    notes: tuple[str, ...]


def run(*overrides: str, config_dir: Path | str | None = None) -> Ran:
    """Play one run: `foundry.run("model=scripted/random", "seed=3")`.

    Args:
        overrides: arguments as after `foundry` on a command line.
        config_dir: folder of your own worlds, prompts and models, and of their code.

    Raises:
        InputError: a part or a setting does not exist, or does not fit the others.
        SweepStopped: no further run can succeed, for example because the server is gone.
    """
    return _play(_arguments(overrides, config_dir))


def sweep(*overrides: str, config_dir: Path | str | None = None) -> Ran:
    """Run a sweep: `foundry.sweep("model=scripted/random,scripted/stay", "seed=0-9")`; complete runs are not repeated.

    Args:
        overrides: arguments as after `foundry -m` on a command line.
        config_dir: folder of your own worlds, prompts and models, and of their code.

    Raises:
        InputError: a part or a setting does not exist, or does not fit the others.
        SweepStopped: no further run can succeed, for example because the server is gone.
    """
    return _play(["-m", *_arguments(overrides, config_dir)])


def _arguments(overrides: Sequence[str], config_dir: Path | str | None) -> list[str]:
    for override in overrides:
        if override.startswith("-"):
            raise InputError(f"'{override}' is a flag of the command. From Python, use overrides such as seed=3.")
    return [*overrides, *([] if config_dir is None else ["--config-dir", str(config_dir)])]


def _play(arguments: Sequence[str]) -> Ran:
    jobs: list[SweepJob] = []

    def play() -> Ran:
        composed = compose(arguments)
        assert composed is not None, "Hydra itself only answers flags, which are refused"
        ready = checked(composed)
        jobs.append(job_of(ready.create(), ready.settings, ready.infos))
        ready.runner.run(jobs[0])
        return _ran(jobs[0].folder, [*filter(None, [composed.left_out]), *ready.notes])

    def stop() -> None:
        for job in jobs:
            job.stop()

    return off_the_loop(play, stop)


def _ran(folder: SweepFolder, notes: Sequence[str]) -> Ran:
    ended = [(run.id, run.summary()) for run in folder.runs()]
    complete = sum(summary is not None and summary.status == "complete" for _, summary in ended)
    failed = tuple(
        f"{run}: {summary.error}" for run, summary in ended if summary is not None and summary.status != "complete"
    )
    return Ran(folder.path, complete, failed, tuple(notes))


def off_the_loop(work: Callable[[], T], stop: Callable[[], None] = lambda: None) -> T:
    """Call `work` in this thread, or in a new thread if an event loop runs in this one, as in a notebook.

    Args:
        work: function that does the work and returns its result.
        stop: function that asks the work in a new thread to end; it is called after Ctrl-C.
    """
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return work()
    done: Future[T] = Future()

    def doing() -> None:
        try:
            done.set_result(work())
        except BaseException as error:  # noqa: BLE001 - the boundary: the waiting thread gets it
            done.set_exception(error)

    try:
        threading.Thread(target=doing, daemon=True).start()
        return done.result()
    except KeyboardInterrupt:
        stop()
        raise
