"""How workers that draw share the cores of a machine."""

from __future__ import annotations

import os

_THREADS = "LP_NUM_THREADS"
"""Environment variable by which Mesa's software driver is told how many threads beside its caller's draw a picture."""


def share_cores(workers: int) -> None:
    """Have software drawing leave the other workers their cores: left alone, each takes all of them for one picture.

    To be called by a worker, before it draws.

    Args:
        workers: how many draw at the same time.
    """
    os.environ.setdefault(_THREADS, str(threads_of(os.cpu_count() or 1, workers)))


def threads_of(cores: int, workers: int) -> int:
    """Return how many threads draw for each worker; 0 where it has one core, and draws by itself."""
    own = cores // workers
    return own if own > 1 else 0
