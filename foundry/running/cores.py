"""Limits how processes use the cores of a machine: the threads that draw, and the time for garbage collection."""

import contextlib
import gc
import os
from collections.abc import Iterator

_THREADS = "LP_NUM_THREADS"
"""Environment variable with the number of further threads that draw a picture in Mesa's software driver."""
_SELDOM = (20_000, 20, 20)
"""Thresholds of Python's garbage collector."""


def share_cores(workers: int) -> None:
    """Limit the threads of software drawing; otherwise each worker uses all cores for one picture.

    A worker must call this before it draws.
    """
    os.environ.setdefault(_THREADS, str(threads_of(os.cpu_count() or 1, workers)))


def threads_of(cores: int, workers: int) -> int:
    """Return the number of further drawing threads of each worker; 0 for a worker with one core."""
    own = cores // workers
    return own if own > 1 else 0


@contextlib.contextmanager
def garbage_sought_seldom() -> Iterator[None]:
    """Collect garbage less often within this context; with thirty open runs, it took a fifth of a worker's CPU time."""
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
    """Let this process end without clean-up, a fifth of a short command's CPU time; files must be closed before."""
    gc.freeze()
