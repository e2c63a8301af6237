"""Runs on machines that share no folder: each worker plays a chunk of them on its own disk and sends them to a URL."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from pathlib import Path

import msgspec

from foundry.errors import InputError
from foundry.expansion import Run, Sweep
from foundry.running.lane import LaneSpec, Tally
from foundry.running.lanes import POLL_S, Lanes
from foundry.running.progress import most_calls
from foundry.running.remote import RemoteSweep
from foundry.storing.store import RunFolder, SweepFolder, write_atomically

CHUNKS_PER_WORKER = 4
"""So many let fast workers take work from slow ones."""
MAX_CHUNK = 256


@dataclass(frozen=True)
class Chunk:
    """Runs that one worker plays on its own disk.

    Attributes:
        spec: what it is given; the sweep of its folder holds the chunk's runs alone.
        url: where the runs are sent.
    """

    spec: LaneSpec
    url: str


@dataclass(frozen=True)
class Played:
    """A chunk that came to its end.

    Attributes:
        name: the chunk.
        runs: ids of its runs.
        fatal: the cause that must end the sweep, or None.
    """

    name: str
    runs: tuple[str, ...]
    fatal: str | None


class RemoteRuns:
    """The command's side: hands out chunks and fetches what has ended."""

    def __init__(self, folder: SweepFolder, remote: RemoteSweep) -> None:
        self._folder = folder
        self._remote = remote
        self._runs = {run.id: run for run in folder.runs()}

    def begin(self) -> None:
        """Send the sweep's definition and fetch what ended in an earlier session.

        Raises:
            InputError: the URL holds another sweep or cannot be used, or this sweep needs a shared folder.
        """
        if self._folder.scenes() or any("fork" in one.config for one in self._folder.sweep.conditions):
            raise InputError(
                "Forks and the scenes of a bundle are read from the sweep's folder: leave out runner.remote, "
                "and put output.dir where all workers see it."
            )
        self._remote.put_sweep(self._folder)
        self._remote.fetch(self._folder, self._runs.values())

    def chunks(self, spec: LaneSpec, workers: int) -> Iterator[Chunk]:
        """Yield the runs of a phase that have not ended, some at a time, until the sweep stops."""
        waiting = [run for run in spec.runs if not self._runs[run].ended]
        size = max(1, min(MAX_CHUNK, -(-len(waiting) // (workers * CHUNKS_PER_WORKER))))
        for start in range(0, len(waiting), size):
            if self._folder.stop_asked(spec.session):
                return
            ids = tuple(waiting[start : start + size])
            part = part_of(self._folder.sweep, [self._runs[run].run for run in ids])
            folder = SweepFolder(self._folder.path, part, self._folder.settings, self._folder.models)
            given = replace(spec, name=f"{spec.name}-{start}", folder=folder, runs=ids, workers=workers, apart=True)
            yield Chunk(given, self._remote.url)

    def take(self, played: Played) -> None:
        """Fetch a chunk's runs and count them for whoever watches the sweep."""
        runs = [self._runs[run] for run in played.runs]
        self._remote.fetch(self._folder, runs)
        tallies, most = dict[str, Tally](), most_calls(runs)
        for run in runs:
            summary = run.summary()
            if summary is not None:
                tallies.setdefault(summary.model, Tally()).end(summary, most[run.run.condition])
        report = {"pid": 0, "open": [], "counts": {}, "models": {name: vars(tally) for name, tally in tallies.items()}}
        write_atomically(self._folder.progress_file(played.name), msgspec.json.encode(report))


def play_chunk(chunk: Chunk, abandoned: Callable[[], bool] = lambda: False) -> Played:
    """Play a chunk on this machine's disk and send every run as it ends; those that are complete there are left out.

    Args:
        chunk: what is to be played.
        abandoned: says whether nobody waits for it any more.

    Raises:
        FoundryError: the runs cannot be sent.
    """
    remote = RemoteSweep.open(chunk.url)
    given = chunk.spec.folder
    with tempfile.TemporaryDirectory(prefix="foundry-") as scratch:
        folder = SweepFolder(Path(scratch), given.sweep, given.settings, given.models)
        folder.start_progress(chunk.spec.session)
        waiting = [run for run in folder.runs() if not remote.complete(folder, run)]
        spec = replace(chunk.spec, folder=folder, runs=tuple(run.id for run in waiting))
        fatal = _play_and_send(spec, waiting, remote, abandoned) if waiting else None
    return Played(chunk.spec.name, chunk.spec.runs, fatal)


def _play_and_send(
    spec: LaneSpec, waiting: list[RunFolder], remote: RemoteSweep, abandoned: Callable[[], bool]
) -> str | None:
    with ThreadPoolExecutor(1) as pool:
        playing = pool.submit(Lanes(spec, 1, abandoned).run)
        while waiting:
            is_over = bool(wait([playing], timeout=POLL_S).done)
            for run in [run for run in waiting if run.ended]:
                remote.put(spec.folder, run)
                waiting.remove(run)
            if is_over:
                break
        return playing.result()


def part_of(sweep: Sweep, runs: Sequence[Run]) -> Sweep:
    """Return the sweep with some of its runs and their conditions alone."""
    used = sorted({run.condition for run in runs})
    conditions = tuple(sweep.conditions[index] for index in used)
    placed = tuple(replace(run, condition=used.index(run.condition)) for run in runs)
    return replace(sweep, conditions=conditions, runs=placed)
