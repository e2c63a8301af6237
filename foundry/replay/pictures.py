"""Draws the steps of runs, one picture a step, on all cores."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass

import joblib

from foundry.replay.recording import Recording, picture_of, redrawing_of
from foundry.replay.tiling import captions, tiled
from foundry.running.cores import share_cores

CHUNK = 8
"""Steps that a worker draws in one go."""
ALONE = 4
"""So few pictures are drawn faster in this process than others are started."""


@dataclass(frozen=True)
class Picture:
    """A PNG of a step."""

    step: int
    png: bytes


def pictures(recordings: Sequence[Recording], steps: Sequence[int], *, workers: int | None = None) -> Iterator[Picture]:
    """Yield a picture of each step, in order.

    One run is shown as `record.frames` keeps it, byte for byte. Several are tiled and captioned; one that is over
    keeps its last state.

    Args:
        recordings: the runs.
        steps: the steps; 0 is the initial state.
        workers: processes that draw; None for one a core.
    """
    chunks = [tuple(steps[start : start + CHUNK]) for start in range(0, len(steps), CHUNK)]
    count = min(workers or joblib.cpu_count(), len(chunks))
    runs = tuple(recordings)
    if count == 1 or len(steps) * len(runs) <= ALONE:
        for chunk in chunks:
            yield from _drawn(runs, chunk)
        return
    yield from _drawn_elsewhere(runs, chunks, count)


def _drawn_elsewhere(runs: tuple[Recording, ...], chunks: Sequence[tuple[int, ...]], workers: int) -> Iterator[Picture]:
    from loky import ProcessPoolExecutor

    pool = ProcessPoolExecutor(max_workers=workers, initializer=share_cores, initargs=(workers,))
    waiting: deque[Future[list[Picture]]] = deque()
    try:
        for chunk in chunks:
            waiting.append(pool.submit(_drawn, runs, chunk))
            if len(waiting) > 2 * workers:
                yield from waiting.popleft().result()
        while waiting:
            yield from waiting.popleft().result()
    finally:
        pool.shutdown(kill_workers=True)


def _drawn(runs: tuple[Recording, ...], steps: Sequence[int]) -> list[Picture]:
    """Draw some steps, one run after the other: going to and fro between scenes would take far longer."""
    columns = [[picture_of(run, redrawing_of(run), min(step, run.last)) for step in steps] for run in runs]
    if len(runs) == 1:
        return [Picture(step, png) for step, png in zip(steps, columns[0], strict=True)]
    texts = captions(runs)
    return [
        Picture(step, tiled(row, [_text(text, run, step) for text, run in zip(texts, runs, strict=True)]))
        for step, row in zip(steps, zip(*columns, strict=True), strict=True)
    ]


def _text(text: str, run: Recording, step: int) -> str:
    if step <= run.last:
        return text
    return f"{text} ({run.note or f'over since step {run.last}'})"
