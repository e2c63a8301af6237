"""What the paper says of its own runs, that no measure holds."""

from __future__ import annotations

import tempfile
from pathlib import Path

from foundry import calling
from foundry.storing.store import SweepFolder


def frames() -> tuple[float, float]:
    """Return how many pictures the paper's 2D run keeps, and the error of that number, which is none.

    Source:
        "Minimal local simulation foundations", table of the 2D example run.
    """
    with tempfile.TemporaryDirectory(prefix="foundry-paper-") as folder:
        where = (f"output.dir={folder}/run", "cache.path=''", "analyze=false")
        ran = calling.sweep("+sweep=paper_2d", "model=scripted/stay", "seed=0", *where)
        (run,) = SweepFolder.open(Path(ran.path)).runs()
        return float(len(run.pictures())), 0.0
