"""Draws steps of runs, one picture per step, on all cores."""

import io
from collections import deque
from collections.abc import Iterator, Sequence
from concurrent.futures import Future
from dataclasses import asdict, dataclass

import joblib
from PIL import Image

from foundry.replay.recording import Recording, picture_of, redrawing_of
from foundry.replay.telling import LINES, said_by_step
from foundry.replay.tiling import Tile, captions, largest, tiled
from foundry.running.cores import share_cores

CHUNK = 8
"""Number of steps that a worker draws at once."""
ALONE = 4
"""Maximum number of pictures that one process draws; for more pictures, several processes are faster."""


@dataclass(frozen=True)
class Picture:
    """A picture (PNG) of the state after a step."""

    step: int
    png: bytes


@dataclass(frozen=True)
class _Sheet:
    """The layout of a picture with several runs: the size of each run's part, and the number of text lines below it."""

    room: tuple[int, int] | None = None
    lines: int = 0


def pictures(
    recordings: Sequence[Recording], steps: Sequence[int], *, workers: int | None = None, film: bool = False
) -> Iterator[Picture]:
    """Yield a picture of each step, in order.

    The pictures of a single run equal those that `record.frames` stores, byte for byte. In a picture of several runs,
    each run has a caption; a run that has ended keeps its last state.

    Args:
        recordings: the runs.
        steps: the steps; 0 is the initial state.
        workers: number of processes; None for one per core.
        film: whether to add captions and messages, and to give all pictures one size.
    """
    sheet = _film_sheet(recordings, steps) if film else _Sheet() if len(recordings) > 1 else None
    chunks = [tuple(steps[start : start + CHUNK]) for start in range(0, len(steps), CHUNK)]
    count = min(workers or joblib.cpu_count(), len(chunks))
    runs = tuple(recordings)
    if count == 1 or len(steps) * len(runs) <= ALONE:
        for chunk in chunks:
            yield from _drawn(runs, chunk, sheet)
        return
    yield from _drawn_elsewhere(runs, chunks, sheet, count)


def film_texts(recordings: Sequence[Recording], steps: Sequence[int]) -> Iterator[str]:
    """Yield the full texts of the captions and messages of a film."""
    yield from captions(recordings)
    for run in recordings:
        for step in steps:
            yield from _captions(run, step)


def _film_sheet(recordings: Sequence[Recording], steps: Sequence[int]) -> _Sheet:
    """Return the layout of a film: the size of its first pictures, and the number of lines of its longest text."""
    opened = [Image.open(io.BytesIO(_picture(run, steps[0]))) for run in recordings]
    spoken = (len(_captions(run, step)) for run in recordings for step in steps)
    return _Sheet(largest(opened), min(LINES, 2 * max(spoken)))


def _drawn_elsewhere(
    runs: tuple[Recording, ...], chunks: Sequence[tuple[int, ...]], sheet: _Sheet | None, workers: int
) -> Iterator[Picture]:
    """Draw the steps in other processes, at most a few chunks ahead, so that pictures do not fill the memory."""
    from loky import ProcessPoolExecutor

    pool = ProcessPoolExecutor(max_workers=workers, initializer=share_cores, initargs=(workers,))
    waiting: deque[Future[list[Picture]]] = deque()
    try:
        for chunk in chunks:
            waiting.append(pool.submit(_drawn, runs, chunk, sheet))
            if len(waiting) > 2 * workers:
                yield from waiting.popleft().result()
        while waiting:
            yield from waiting.popleft().result()
    finally:
        pool.shutdown(kill_workers=True)


def _drawn(runs: tuple[Recording, ...], steps: Sequence[int], sheet: _Sheet | None) -> list[Picture]:
    """Draw some steps of all runs, one run after another, so that each scene is loaded only once."""
    columns = [[_picture(run, step) for step in steps] for run in runs]
    if sheet is None:
        return [Picture(step, png) for step, png in zip(steps, columns[0], strict=True)]
    texts = captions(runs)
    return [
        Picture(step, tiled([_tile(*parts, step) for parts in zip(runs, texts, row, strict=True)], **asdict(sheet)))
        for step, row in zip(steps, zip(*columns, strict=True), strict=True)
    ]


def _picture(run: Recording, step: int) -> bytes:
    return picture_of(run, redrawing_of(run), min(step, run.last))


def _tile(run: Recording, text: str, png: bytes, step: int) -> Tile:
    over = f" ({run.note or f'ended after step {run.last}'})"
    return Tile(png, f"{text}, step {step}" if step <= run.last else text + over, _captions(run, step))


def _captions(run: Recording, step: int) -> Sequence[str]:
    return (*said_by_step(run).get(step, ()), *redrawing_of(run).told(step))
