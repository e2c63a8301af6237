"""What a page can ask for, by address; the server and the export hand out the same.

The addresses and the keys of what they return are documented in `docs/viewer.md`.
"""

from __future__ import annotations

import re
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

from foundry.errors import InputError
from foundry.storing.store import RunFolder
from foundry.viewer.camera.view import CameraView
from foundry.viewer.catalog import ROWS_PER_PAGE, Catalog, CatalogedSweep
from foundry.viewer.grid.view import GridView
from foundry.viewer.run_view import MARKS_PER_BLOCK, RunView

JSON, BINARY = "application/json", "application/octet-stream"
_OPEN_RUNS = 8
_NUMBER = re.compile(r"\d{1,9}")
_ENCODE = msgspec.json.Encoder().encode


@dataclass(frozen=True)
class Resource:
    """What an address stands for.

    Attributes:
        content: the bytes.
        media_type: what they are.
    """

    content: bytes
    media_type: str = JSON


def open_view(folder: RunFolder, *, decisions_per_chunk: int = 10) -> RunView:
    """Return the view that fits the run's world: one with a grid, or one with a camera."""
    is_grid = {"half_size", "places"} <= folder.config()["world"].keys()
    return (GridView if is_grid else CameraView)(folder, decisions_per_chunk=decisions_per_chunk)


class Resources:
    """Answers for the sweeps below a folder; may be asked from several threads.

    Args:
        root: a sweep's folder, or a folder of sweeps.
        decisions_per_chunk: steps in one chunk of decisions.
    """

    def __init__(self, root: Path, *, decisions_per_chunk: int = 10) -> None:
        self.catalog = Catalog(root)
        self._decisions_per_chunk = decisions_per_chunk
        self._views: OrderedDict[tuple[str, str], tuple[str, RunView]] = OrderedDict()
        self._lock, self._scene_lock = threading.RLock(), threading.Lock()

    def close(self) -> None:
        """Free what was kept."""
        with self._lock:
            for _, view in self._views.values():
                view.close()
            self._views.clear()

    def get(self, address: str) -> Resource:
        """Return what an address stands for.

        Raises:
            InputError: nothing.
            RecordError: the records it is made of cannot be read.
        """
        kind, *rest = address.split("/")
        if kind == "sweeps" and not rest:
            with self._lock:
                sweeps = self.catalog.overview()
                return Resource(_ENCODE({"sweeps": sweeps, "unreadable": self.catalog.unreadable}))
        if kind == "sweep" and rest:
            with self._lock:
                return Resource(_ENCODE(self._of_sweep(self.catalog.sweep(rest[0]), rest[1:])))
        if kind == "run" and len(rest) >= 3:
            view = self.view(rest[0], rest[1])
            if rest[2:] == ["progress"]:
                running = rest[1] in self.catalog.sweep(rest[0]).open_runs()
                return Resource(_ENCODE(view.progress(running=running)))
            if rest[2:] == ["scene"]:
                return Resource(self._scene(view) or b"", BINARY)
            return Resource(_ENCODE(_of_run(view, rest[2], _numbers(rest[3:]))))
        raise InputError(f"There is nothing at '{address}'.")

    def view(self, sweep: str, run: str) -> RunView:
        """Return the view of a run; a new one once the run was started anew."""
        with self._lock:
            folder = self.catalog.sweep(sweep).run(run)
            kept = self._views.pop((sweep, run), None)
            if kept is not None and kept[0] != folder.beginning:
                kept[1].close()
                kept = None
            if kept is None:
                kept = folder.beginning, open_view(folder, decisions_per_chunk=self._decisions_per_chunk)
            self._views[sweep, run] = kept
            while len(self._views) > _OPEN_RUNS:
                self._views.popitem(last=False)[1][1].close()
            return kept[1]

    def _of_sweep(self, sweep: CatalogedSweep, rest: list[str]) -> Any:
        if not rest:
            return sweep.head()
        what, numbers = rest[0], _numbers(rest[1:])
        if what == "rows" and len(numbers) == 1:
            return {"rows": sweep.rows(numbers[0] * ROWS_PER_PAGE, (numbers[0] + 1) * ROWS_PER_PAGE)}
        measures = list(sweep.measures().items())
        if what == "measure" and len(numbers) == 1 and numbers[0] < len(measures):
            name, values = measures[numbers[0]]
            return {"name": name, "values": values}
        raise InputError(f"A sweep has no '{'/'.join(rest)}'.")

    def _scene(self, view: RunView) -> bytes | None:
        """Return the scene of a run as GLB; None when its world has none. Two pages must not make it at once."""
        from foundry.viewer.camera.scene_export import kept_scene_glb

        try:
            with self._scene_lock:
                return kept_scene_glb(view.folder)
        except OSError as error:
            raise InputError(f"The scene cannot be kept in the sweep's folder: {error}") from error


def _numbers(texts: list[str]) -> list[int]:
    if not all(_NUMBER.fullmatch(text) for text in texts):
        raise InputError(f"'{'/'.join(texts)}' are not numbers.")
    return [int(text) for text in texts]


def _frames(view: RunView, chunk: int) -> Any:
    return view.frames(*view.chunk(chunk, view.steps_per_chunk))


def _marks(view: RunView, block: int) -> Any:
    first, last = view.chunk(block, MARKS_PER_BLOCK)
    return {"first": first, "last": last, "marks": view.marks(first, last)}


def _texts(view: RunView, chunk: int) -> Any:
    first, last = view.chunk(chunk, view.steps_per_chunk)
    return {"first": first, "last": last, "texts": view.texts(first, last)}


def _decisions(view: RunView, chunk: int, agent: int) -> Any:
    return view.decisions(agent, *view.chunk(chunk, view.decisions_per_chunk))


def _track(view: RunView, agent: int) -> Any:
    view.steps.grow()
    return view.track(agent)


_OF_RUN: Mapping[tuple[str, int], Callable[..., Any]] = {
    ("about", 0): RunView.about,
    ("frames", 1): _frames,
    ("marks", 1): _marks,
    ("texts", 1): _texts,
    ("decisions", 2): _decisions,
    ("track", 1): _track,
}


def _of_run(view: RunView, what: str, numbers: list[int]) -> Any:
    answer = _OF_RUN.get((what, len(numbers)))
    if answer is None:
        raise InputError(f"A run has no '{what}' with {len(numbers)} numbers.")
    return answer(view, *numbers)


def addresses_of_run(view: RunView) -> Iterator[str]:
    """Yield every address below a run, as far as it is recorded, but those of single agents."""
    view.steps.grow()
    yield from ("about", "progress")
    yield from (
        f"{what}/{chunk}" for what in ("frames", "texts") for chunk in range(_parts(view.done, view.steps_per_chunk))
    )
    yield from (f"marks/{block}" for block in range(_parts(view.done, MARKS_PER_BLOCK)))
    if view.kind == "camera":
        yield "scene"


def resources_of_agents(view: RunView) -> Iterator[tuple[str, Resource]]:
    """Yield the addresses below a run that are of single agents, and what they stand for; reads everything once."""
    view.steps.grow()
    for agent, track in view.all_tracks():
        yield f"track/{agent}", Resource(_ENCODE(track))
    for chunk in range(_parts(view.done, view.decisions_per_chunk)):
        for agent, decisions in view.all_decisions(*view.chunk(chunk, view.decisions_per_chunk)):
            yield f"decisions/{chunk}/{agent}", Resource(_ENCODE(decisions))


def _parts(total: int, size: int) -> int:
    return -(-total // size)
