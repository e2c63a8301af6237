"""Starts a worker in a process of its own, which runs `python -m foundry.running.lane_process`."""

import contextlib
import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future

from foundry.running.cores import leave_all_to_the_system
from foundry.running.lane import LaneSpec


class WorkerDied(Exception):
    """A worker's process ended before its work was done."""


class LaneProcess:
    """The process of one worker; other workers go on if it dies.

    Pools of `multiprocessing` do not work here: a worker of Dask may be a daemon, which may not start their processes.

    Attributes:
        ended: future with the result of the work; it raises the worker's error, or `WorkerDied`.
    """

    def __init__(self, work: Callable[[LaneSpec], str | None], spec: LaneSpec) -> None:
        """Start a process that calls `work(spec)`; it can import the same modules as this process."""
        command = [sys.executable, "-P", "-m", "foundry.running.lane_process"]
        importable = os.pathsep.join(entry or os.getcwd() for entry in sys.path)
        with _interrupts_held_back():
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                env={**os.environ, "PYTHONPATH": importable},
                creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
            )
        self.ended: Future[str | None] = Future()
        waiting = (self._process, pickle.dumps((work, spec)), self.ended)
        threading.Thread(target=_await, args=waiting, daemon=True).start()

    def kill(self) -> None:
        """End the process, unless it has ended."""
        self._process.kill()


@contextlib.contextmanager
def _interrupts_held_back() -> Iterator[None]:
    """Block Ctrl-C within this context, so that a process that starts in it never gets Ctrl-C."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _await(process: subprocess.Popen[bytes], task: bytes, ended: Future[str | None]) -> None:
    output, _ = process.communicate(task)
    if process.returncode != 0:
        ended.set_exception(WorkerDied(f"The process of a worker ended with exit code {process.returncode}."))
        return
    result = pickle.loads(output)
    if isinstance(result, Exception):
        ended.set_exception(result)
    else:
        ended.set_result(result)


def main() -> None:
    """Do the work that comes on standard input, and write its result, and nothing else, to standard output."""
    answer = os.dup(1)
    os.dup2(2, 1)
    work, spec = pickle.load(sys.stdin.buffer)
    try:
        result = work(spec)
    except Exception as error:  # noqa: BLE001 - the boundary: the waiting process gets it
        result = error
    with os.fdopen(answer, "wb") as file:
        pickle.dump(result, file)
    leave_all_to_the_system()


if __name__ == "__main__":
    main()
