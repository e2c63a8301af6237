"""Exchanges runs through a URL of fsspec: workers send the runs that they played, and the command fetches them."""

import contextlib
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import msgspec

from foundry.errors import FoundryError, InputError
from foundry.expansion import Run, Sweep
from foundry.records import RunSummary
from foundry.running.lane import LaneSpec, Tally
from foundry.running.lanes import POLL_S, Lanes
from foundry.running.progress import most_calls
from foundry.storing.run_files import sha256_of
from foundry.storing.store import ENDED_RUNS, SWEEP_FILE, RunFolder, SweepFolder, is_sweep, write_atomically
from foundry.texts import one_line, without_secrets

_INSTALL = "pip install 'foundry-worlds[remote]'"
CHUNKS_PER_WORKER = 4
"""The runs are divided into this number of chunks per worker, so that fast workers can take more than slow ones."""
MAX_CHUNK = 256


@dataclass(frozen=True)
class Fetched:
    """The runs that were fetched from a URL.

    Attributes:
        folder: the sweep into which they were fetched.
        damaged: ids of the runs whose files differ from the digests in `run.json`; they count as not ended.
    """

    folder: SweepFolder
    runs: tuple[str, ...]
    damaged: tuple[str, ...]


class RemoteSweep:
    """The folder of a sweep at a URL; files there are only written whole, since object stores cannot append."""

    def __init__(self, url: str, filesystem: Any, root: str) -> None:
        self.url = url
        self._shown = without_secrets(url)
        self._filesystem = filesystem
        self._root = root.rstrip("/")

    @classmethod
    def open(cls, url: str) -> "RemoteSweep":
        """Return an object for the sweep at a URL; nothing is read there yet."""
        try:
            from fsspec.core import url_to_fs
        except ImportError as error:
            raise InputError(
                f"'{without_secrets(url)}' needs a package that is not installed. Install it: {_INSTALL}"
            ) from error
        try:
            filesystem, root = url_to_fs(url)
        except Exception as error:  # the boundary: every driver has its own errors
            cause = one_line(error) or type(error).__name__
            raise InputError(f"'{without_secrets(url)}' cannot be opened: {without_secrets(cause)}") from error
        return cls(url, filesystem, root)

    def ended(self) -> set[str]:
        """Return the ids of the ended runs at the URL."""
        with self._naming_url():
            return {name.rsplit("/", 2)[-2] for name in self._filesystem.glob(f"{self._root}/{ENDED_RUNS}")}

    def complete(self, folder: SweepFolder, run: RunFolder) -> bool:
        """Return whether the URL has a complete record of a run."""
        with self._naming_url():
            try:
                content = self._filesystem.cat_file(self._place(folder, run.path / "run.json"))
            except FileNotFoundError:
                return False
        summary = _summary(content)
        return summary is not None and summary.status == "complete"

    def put(self, folder: SweepFolder, run: RunFolder) -> None:
        """Send the files of an ended run to the URL, and `run.json` last, as a sign that all of them are there."""
        self._send(folder, run.files())

    def put_sweep(self, folder: SweepFolder) -> None:
        """Send `sweep.yaml` to the URL, unless it is already there."""
        try:
            here, there = SweepFolder.open(folder.path).sweep, self._sweep_there()
            if there is None or _grows_into(there, here):
                self._send(folder, [folder.path / SWEEP_FILE])
            elif there.definition != here.definition:
                raise self._other(folder.path)
        except FoundryError as error:
            raise InputError(str(error)) from error

    def fetch_sweep(self, path: Path) -> SweepFolder:
        """Fetch `sweep.yaml` into a folder, which may already contain the sweep, and return the folder."""
        there = self._sweep_there()
        if there is None:
            raise InputError(f"There is no sweep at '{self._shown}'. Give the URL that the sweep had as runner.remote.")
        here = SweepFolder.open(path).sweep if is_sweep(path) else None
        if here is None or _grows_into(here, there):
            with self._naming_url():
                content = self._filesystem.cat_file(f"{self._root}/{SWEEP_FILE}")
                path.mkdir(parents=True, exist_ok=True)
                write_atomically(path / SWEEP_FILE, content)
        elif here.definition != there.definition and not _grows_into(there, here):
            raise self._other(path)
        return SweepFolder.open(path)

    def fetch(self, folder: SweepFolder, runs: Iterable[RunFolder]) -> Fetched:
        """Fetch each of these runs that has ended at the URL, but not in the folder."""
        there = self.ended()
        wanted = [run for run in runs if run.id in there and not run.ended]
        whole = {run.id: self._get(folder, run) for run in wanted}
        damaged = tuple(run for run, came in whole.items() if not came)
        return Fetched(folder, tuple(run for run, came in whole.items() if came), damaged)

    def _get(self, folder: SweepFolder, run: RunFolder) -> bool:
        """Fetch the files of a run, and `run.json` as the last; return False if they differ from the digests in it."""
        shutil.rmtree(run.path, ignore_errors=True)
        place = self._place(folder, run.path)
        with self._naming_url():
            for name in self._filesystem.find(place):
                file = (run.path / name[len(place) + 1 :]).resolve()
                if file.name != "run.json" and file.is_relative_to(run.path.resolve()):
                    file.parent.mkdir(parents=True, exist_ok=True)
                    self._filesystem.get_file(name, str(file))
            content = self._filesystem.cat_file(f"{place}/run.json")
        summary = _summary(content)
        if summary is None or any(_digest(run.path / name) != sha for name, sha in summary.records_sha256.items()):
            return False
        run.path.mkdir(parents=True, exist_ok=True)
        write_atomically(run.path / "run.json", content)
        return True

    def _sweep_there(self) -> Sweep | None:
        with self._naming_url(), tempfile.TemporaryDirectory() as scratch:
            try:
                content = self._filesystem.cat_file(f"{self._root}/{SWEEP_FILE}")
            except FileNotFoundError:
                return None
            (Path(scratch) / SWEEP_FILE).write_bytes(content)
            return SweepFolder.open(scratch).sweep

    def _other(self, path: Path) -> InputError:
        return InputError(f"'{self._shown}' holds another sweep than '{path}'. Name another URL or another folder.")

    def _send(self, folder: SweepFolder, files: Iterable[Path]) -> None:
        with self._naming_url():
            for file in files:
                place = self._place(folder, file)
                self._filesystem.makedirs(place.rpartition("/")[0], exist_ok=True)
                self._filesystem.put_file(str(file), place)

    def _place(self, folder: SweepFolder, path: Path) -> str:
        return f"{self._root}/{path.relative_to(folder.path).as_posix()}"

    @contextlib.contextmanager
    def _naming_url(self) -> Iterator[None]:
        """Turn errors of the URL's driver within this context into errors that name the URL."""
        try:
            yield
        except FoundryError:
            raise
        except Exception as error:  # the boundary: every driver has its own errors
            cause = without_secrets(one_line(error)) or type(error).__name__
            raise FoundryError(f"'{self._shown}' cannot be used ({type(error).__name__}: {cause}).") from error


def fetch(url: str, path: Path) -> Fetched:
    """Fetch the runs that have ended at a URL but not in a folder; return the sweep and which runs were fetched."""
    remote = RemoteSweep.open(url)
    folder = remote.fetch_sweep(path)
    return remote.fetch(folder, folder.runs())


def _grows_into(first: Sweep, other: Sweep) -> bool:
    return {run.id for run in first.runs} < {run.id for run in other.runs}


def _summary(content: bytes) -> RunSummary | None:
    try:
        return msgspec.json.decode(content, type=RunSummary)
    except msgspec.DecodeError:
        return None


def _digest(path: Path) -> str | None:
    return sha256_of(path.read_bytes()) if path.exists() else None


@dataclass(frozen=True)
class Chunk:
    """A chunk: some runs of a sweep, which one worker plays on its own disk and sends to a URL.

    Attributes:
        spec: input of the worker; its sweep only contains the runs of the chunk.
        url: where the worker sends the runs.
    """

    spec: LaneSpec
    url: str


@dataclass(frozen=True)
class Played:
    """The result of a task: the runs that a worker has played, as one chunk.

    Attributes:
        fatal: the cause that must end the sweep, or None.
    """

    name: str
    runs: tuple[str, ...]
    fatal: str | None


class RemoteRuns:
    """Divides the runs of a sweep into chunks for the workers, and fetches the runs that they have played."""

    def __init__(self, folder: SweepFolder, remote: RemoteSweep) -> None:
        self._folder = folder
        self._remote = remote
        self._runs = {run.id: run for run in folder.runs()}

    def begin(self) -> None:
        """Send `sweep.yaml` to the URL, and fetch the runs that ended at the URL in earlier sessions."""
        if self._folder.scenes() or any("fork" in condition.config for condition in self._folder.sweep.conditions):
            raise InputError(
                "Forks and the scenes of a bundle are read from the sweep's folder, so runner.remote cannot be used. "
                "Leave it out, and put output.dir where all workers see it."
            )
        self._remote.put_sweep(self._folder)
        self._remote.fetch(self._folder, self._runs.values())

    def chunks(self, spec: LaneSpec, workers: int) -> Iterator[Chunk]:
        """Yield chunks of the unfinished runs of a phase, until the sweep stops."""
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
        """Fetch the runs that a worker has played, and add these runs to the progress of the sweep."""
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
    """Play the runs of a chunk in a temporary folder, and send each run when it ends; skip runs that the URL has."""
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
    """Return a sweep that has only the given runs and the conditions of these runs."""
    used = sorted({run.condition for run in runs})
    conditions = tuple(sweep.conditions[index] for index in used)
    placed = tuple(replace(run, condition=used.index(run.condition)) for run in runs)
    return replace(sweep, conditions=conditions, runs=placed)
