"""Saves CPU time of a process: limits its threads, and lets it collect garbage less often."""

import contextlib
import gc
import os
from collections.abc import Iterator

_THREADS = "LP_NUM_THREADS"
"""The environment variable that sets how many further threads of Mesa's software driver draw a picture."""
_ALGEBRA_THREADS = "OPENBLAS_NUM_THREADS"
"""The environment variable that sets how many threads numpy uses to multiply matrices."""
_SELDOM = (20_000, 20, 20)
"""Thresholds for Python's garbage collector (`gc.set_threshold`) with which it seldom runs."""


def share_cores(workers: int) -> None:
    """Limit the threads that draw pictures without a GPU, because otherwise each worker would use all cores.

    A worker must call this before it draws.
    """
    os.environ.setdefault(_THREADS, str(threads_of(os.cpu_count() or 1, workers)))


def threads_of(cores: int, workers: int) -> int:
    """Return how many extra threads each worker may use to draw; 0 if a worker has only one core."""
    own = cores // workers
    return own if own > 1 else 0


def multiply_in_one_thread() -> None:
    """Let numpy multiply matrices in one thread, because further threads would mostly wait for work.

    A process must call this before it imports numpy. The setting also holds for the processes that it starts.
    """
    os.environ.setdefault(_ALGEBRA_THREADS, "1")


@contextlib.contextmanager
def garbage_sought_seldom() -> Iterator[None]:
    """Collect garbage less often within this context; it took a fifth of the CPU time of a worker with 30 open runs."""
    before = gc.get_threshold()
    seek_garbage_seldom()
    try:
        yield
    finally:
        gc.set_threshold(*before)


def seek_garbage_seldom() -> None:
    """Collect garbage less often from now on."""
    gc.set_threshold(*_SELDOM)


def leave_all_to_the_system() -> None:
    """Let this process end without a clean-up, which takes a fifth of a short command's CPU time.

    Files must be closed before.
    """
    gc.freeze()
