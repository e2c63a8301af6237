"""One worker in a separate process; `python -m foundry.running.lane_process` is that process."""

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
    """A worker's process ended before its work."""


class LaneProcess:
    """A process for one worker; its death is reported and harms no other.

    Pools of processes cannot be used everywhere: a Dask worker may be a daemon, which may have no child that
    `multiprocessing` knows of.

    Attributes:
        ended: the result of the work, its error, or `WorkerDied`.
    """

    def __init__(self, work: Callable[[LaneSpec], str | None], spec: LaneSpec) -> None:
        """Start the work; what this process can import, that one can."""
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
    """Start processes that Ctrl-C does not reach, from their first instruction on: it is this process' to handle."""
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
        ended.set_exception(WorkerDied(f"The process ended with {process.returncode}."))
        return
    result = pickle.loads(output)
    if isinstance(result, Exception):
        ended.set_exception(result)
    else:
        ended.set_result(result)


def main() -> None:
    """Do the work that standard input holds and write its result to standard output, where nothing else may write."""
    answer = os.dup(1)
    os.dup2(2, 1)
    work, spec = pickle.load(sys.stdin.buffer)
    try:
        result = work(spec)
    except Exception as error:  # noqa: BLE001 - the boundary: handed on to the process that waits
        result = error
    with os.fdopen(answer, "wb") as file:
        pickle.dump(result, file)
    leave_all_to_the_system()


if __name__ == "__main__":
    main()
