"""How processes use the cores of a machine: threads of those that draw, time spent on looking for garbage."""

import contextlib
import gc
import os
from collections.abc import Iterator

_THREADS = "LP_NUM_THREADS"
"""Environment variable with the number of further threads that draw a picture in Mesa's software driver."""
_SELDOM = (20_000, 20, 20)
"""Thresholds of the collector of cyclic garbage."""


def share_cores(workers: int) -> None:
    """Have software drawing leave the other workers their cores: left alone, each takes all of them for one picture.

    To be called by a worker, before it draws.
    """
    os.environ.setdefault(_THREADS, str(threads_of(os.cpu_count() or 1, workers)))


def threads_of(cores: int, workers: int) -> int:
    """Return the number of further drawing threads of each worker; 0 for a worker with one core."""
    own = cores // workers
    return own if own > 1 else 0


@contextlib.contextmanager
def garbage_sought_seldom() -> Iterator[None]:
    """Look for cyclic garbage less often until the end: with thirty runs open, a fifth of a worker's CPU went there."""
    before = gc.get_threshold()
    seek_garbage_seldom()
    try:
        yield
    finally:
        gc.set_threshold(*before)


def seek_garbage_seldom() -> None:
    """Look for cyclic garbage less often from now on."""
    gc.set_threshold(*_SELDOM)


def leave_all_to_the_system() -> None:
    """Have this process take nothing apart as it ends, a fifth of a short command's CPU; files must be closed."""
    gc.freeze()
