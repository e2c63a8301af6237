"""One worker in a process that `multiprocessing` knows nothing of; `python -m foundry.lane_process` is that process."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import Future

from joblib.externals.loky.process_executor import BrokenProcessPool

from foundry.lane import LaneSpec


class LaneProcess:
    """A process for one worker, where pools cannot start any: a Dask worker may be a daemon, which may have no child.

    A child apart keeps a run that kills its process from killing the Dask worker, and the two from sharing a GIL.
    """

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None

    def submit(self, work: Callable[[LaneSpec], str | None], spec: LaneSpec, /) -> Future[str | None]:
        """Start the work; the future raises `BrokenProcessPool` when the process died."""
        command = [sys.executable, "-m", "foundry.lane_process"]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        future: Future[str | None] = Future()
        waiting = (self._process, pickle.dumps((work, spec)), future)
        threading.Thread(target=_await, args=waiting, daemon=True).start()
        return future

    def shutdown(self, *, wait: bool, kill_workers: bool) -> None:
        """Free the process; a process that ended by itself is gone already."""
        assert self._process is not None
        if kill_workers:
            self._process.kill()
        if wait:
            self._process.wait()


def _await(process: subprocess.Popen[bytes], task: bytes, future: Future[str | None]) -> None:
    output, _ = process.communicate(task)
    if process.returncode != 0:
        future.set_exception(BrokenProcessPool(f"The process ended with {process.returncode}."))
        return
    result = pickle.loads(output)
    if isinstance(result, Exception):
        future.set_exception(result)
    else:
        future.set_result(result)


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


if __name__ == "__main__":
    main()
