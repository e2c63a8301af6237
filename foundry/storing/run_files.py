"""The files in the folder of one run; `foundry.storing.store` also offers these names."""

import contextlib
import errno
import hashlib
import os
import threading
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager
from functools import cached_property
from pathlib import Path, PurePath
from typing import Any, TypeVar

import msgspec
import zstandard

from foundry.errors import RecordError, StorageError, UndeclaredError
from foundry.expansion import Run, Sweep, calls_seed
from foundry.records import NOT_JSON, Call, Counts, RunSummary
from foundry.storing.plain import check_entries, check_folder, is_there, plain, stamp_of
from foundry.storing.sweep_file import declared_before

RECORD_STREAMS = ("steps", "messages", "episode", "agents")
ALWAYS_THERE = ("steps", "messages")
"""The record files that every run has; they may be empty."""
IMAGES = "images"
ENDED_RUNS = "runs/*/run.json"
"""The pattern for all `run.json` files of a sweep; each of them shows that its run has ended."""
KEPT = ("frames", IMAGES)
"""The folders of a run that contain pictures."""
PROBE = "foundry.worlds.probe.probe_world.ProbeScenario"
"""The class of the world of a probe; its moments are in the sweep's folder."""
MOMENTS_FILE = "moments.json"
ORIGINS, PAST = "origins", "{}-past.jsonl.zst"
"""The folder for files from other sweeps, and the name of its files with answers; `{}` stands for the run's id."""
FIXTURES = "fixtures"
"""The record file with the positions of places and fires that a 2D world drew at random."""
_OWN_HOUSE = frozenset((*RECORD_STREAMS, *KEPT))
_ENCODE = msgspec.json.Encoder().encode
_READ_AT_ONCE = 1 << 16
"""Bytes of a log that are unpacked at once; many readers need only the calls of the first steps."""
T = TypeVar("T")


def write_atomically(path: Path, content: bytes) -> None:
    """Write a file such that readers see either the old file or the whole new one, even after a crash."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}.{threading.get_ident()}.tmp")
    try:
        temporary.write_bytes(content)
        temporary.replace(path)
    except OSError:
        temporary.unlink(missing_ok=True)  # a partial file would occupy a full disk
        raise


def cannot_write(path: Path, error: OSError) -> StorageError:
    """Return the error that ends a sweep because the system refused to write a file."""
    cause = errno.errorcode.get(error.errno or 0, "error")
    return StorageError(
        f"'{path}' cannot be written ({cause}: {error.strerror}). Free space or fix the cause, then use foundry resume."
    )


@contextlib.contextmanager
def storing(path: Path) -> Iterator[None]:
    """Within this context, turn errors of the operating system into errors that end the sweep and name the path."""
    try:
        yield
    except OSError as error:
        raise cannot_write(path, error) from error


def scene_here(config: Mapping[str, Any], scenes: Mapping[str, str], sweep: Path) -> dict[str, Any]:
    """Return a run's configuration; if a bundle contained its scene, the scene is read from the sweep's folder.

    Args:
        config: the run's configuration.
        scenes: files of the scenes that a bundle contained, by their names in the sweep.
        sweep: the sweep's folder.
    """
    scene = config["world"].get("scene") if isinstance(config.get("world"), Mapping) else None
    if not isinstance(scene, Mapping):
        return dict(config)
    file = scenes.get(str(scene.get("asset")))
    if file is None:
        return dict(config)
    here = {"asset": file, "root": str(sweep)}
    return {**config, "world": {**config["world"], "scene": {**scene, **here}}}


def moments_here(config: Mapping[str, Any], sweep: Path) -> dict[str, Any]:
    """Return a run's configuration; the world of a probe reads the moments in the sweep's folder."""
    world = config.get("world")
    if not isinstance(world, Mapping) or world.get("_target_") != PROBE:
        return dict(config)
    files = {"moments": str(sweep / MOMENTS_FILE), "past": str(sweep / ORIGINS / PAST.format("{run}"))}
    return {**config, "world": {**world, "kept": files}}


class _Fixture(msgspec.Struct, frozen=True):
    kind: str
    name: str
    x: int
    y: int


class RunFolder:
    """The folder of one run: the paths of its files, and methods that read them.

    Attributes:
        factors: the swept settings, and their values in this run.
        declared: the world's declaration of its records.
        declared_then: the declaration in `sweep.yaml`; None in sweeps of 0.1, which have none.
        streams: names of the record files without `.jsonl`; the files that every world may have come first.
    """

    def __init__(self, sweep_path: Path, run: Run, sweep: Sweep, scenes: Mapping[str, str] | None = None) -> None:
        self.id = run.id
        self.run = run
        self._sweep_path = sweep_path
        condition = sweep.conditions[run.condition]
        self.factors = dict(condition.factors)
        self.declared_then = condition.declared
        self.declared = condition.declared or declared_before(condition.config)
        self.streams = (*RECORD_STREAMS, *(name for name in self.declared.streams if name not in _OWN_HOUSE))
        self._sweep = sweep
        self._scenes = scenes or {}

    # Paths are made when they are needed: a sweep may have very many runs, and a path takes longer than all the rest.
    @cached_property
    def path(self) -> Path:
        """The run's folder, which exists once the run has started."""
        return self._sweep_path / "runs" / self.id

    @property
    def model_place(self) -> int:
        """The index of the run's model in the sweep, which determines the model's colour and marker in plots."""
        return self._sweep.model_names().index(self._sweep.conditions[self.run.condition].config["model"]["name"])

    @cached_property
    def replay_dir(self) -> Path:
        """The folder for pictures that are drawn from the records; it may be deleted."""
        return self._sweep_path / "analysis" / "replay" / self.id

    @cached_property
    def _end_file(self) -> Path:
        return self.path / "run.json"

    def config(self) -> dict[str, Any]:
        """Return the run's configuration; scenes and moments that came with the sweep are read from its folder."""
        return moments_here(scene_here(self.recorded_config(), self._scenes, self._sweep_path), self._sweep_path)

    def recorded_config(self) -> dict[str, Any]:
        """Return the run's configuration as `sweep.yaml` records it."""
        return self._sweep.config(self.run)

    def world(self) -> dict[str, Any]:
        """Return the settings of the run's world; randomly drawn positions are filled in from the records.

        A place or fire without a recorded position is left out, for example before the run starts.
        """
        world: dict[str, Any] = self.config()["world"]
        if FIXTURES not in self.declared.streams or not world.get("draw_positions"):
            return world
        lines = lines_of(whole_lines(self._bytes(f"{FIXTURES}.jsonl")), _Fixture, self.path / f"{FIXTURES}.jsonl")
        cells = {(line.kind, line.name): [line.x, line.y] for line in lines}
        placed = {
            key: [
                {**thing, position: cells[key, thing["name"]]}
                for thing in world.get(key) or ()
                if (key, thing["name"]) in cells
            ]
            for key, position in (("places", "center"), ("fires", "position"))
        }
        return {**world, **placed}

    def pictures(self) -> list[str]:
        """Return the paths of stored frames and images, relative to the run's folder."""
        files = [file for subfolder in KEPT for file in sorted(plain(self.path / subfolder).glob("*"))]
        return [file.relative_to(self.path).as_posix() for file in files if plain(file).is_file()]

    def check_declared(self, streams: Iterable[str]) -> None:
        """Raise an error unless the run's world declares each of these record files."""
        known = self.declared.streams or dict.fromkeys((*RECORD_STREAMS, IMAGES))
        for name in streams:
            if name not in known:
                raise UndeclaredError(
                    f"the world wrote a record of stream '{name}', which it does not declare. Declared are "
                    f"{', '.join(known)}. Add the record's class to `records` of its Scenario."
                )

    @property
    def calls_seed(self) -> int:
        """The seed from which foundry derives the sampling seeds of the run's calls."""
        return calls_seed(self.config())

    @property
    def ended(self) -> bool:
        """True if the run is complete or failed, that is, if `run.json` exists."""
        return is_there(self._end_file)

    @property
    def ending(self) -> str:
        """A text that changes each time the run ends, also after it was started anew; "" if it has never ended."""
        return stamp_of(self._end_file)

    def summary(self) -> RunSummary | None:
        """Return the content of `run.json`, or None if the run has not ended."""
        summary = json_file(self._end_file, RunSummary)
        if summary is not None:  # a restarted run replaces all files
            check_entries(self.path)
        return summary

    @property
    def is_complete(self) -> bool:
        """True if the run has ended without failure."""
        summary = self.summary()
        return summary is not None and summary.status == "complete"

    def stream_path(self, name: str) -> Path:
        """Return the path of a record file, such as "steps", which may not exist; "calls" is the log of calls."""
        return plain(self.stream_file(name))

    def stream_file(self, name: str) -> Path:
        """Return the path of a record file without checking that it is a regular file, for writers."""
        return self.path / ("calls.jsonl.zst" if name == "calls" else f"{name}.jsonl")

    @property
    def beginning(self) -> str:
        """A text that changes each time the run is started anew, from its first step; "" if it has never started."""
        return stamp_of(self.path / "config.yaml")

    def steps_bytes(self) -> bytes:
        """Return the content of `steps.jsonl`; b"" if the file has no line yet."""
        return self._bytes("steps.jsonl")

    def messages_bytes(self) -> bytes:
        """Return the content of `messages.jsonl`; b"" if the file has no line yet."""
        return self._bytes("messages.jsonl")

    def agents_bytes(self) -> bytes:
        """Return the content of `agents.jsonl`; b"" in a world without personas."""
        return self._bytes("agents.jsonl")

    def episode_bytes(self) -> bytes:
        """Return the content of `episode.jsonl`; b"" in a world that writes no such file."""
        return self._bytes("episode.jsonl")

    def calls(self) -> Iterator[Call]:
        """Yield the logged calls; if a crash cut the log, yield its complete calls."""
        yield from read_calls(self.path / "calls.jsonl.zst")

    def _bytes(self, name: str) -> bytes:
        return _content(self.path / name) or b""

    def stamp(self) -> str:
        """Return a text that changes whenever a record file of the run changes."""
        stamps = []
        for name in ("run.json", *(f"{stream}.jsonl" for stream in self.streams), "calls.jsonl.zst"):
            with contextlib.suppress(FileNotFoundError, NotADirectoryError):
                status = plain(self.path / name).stat()
                stamps.append(f"{name} {status.st_size} {status.st_mtime_ns}")
        return "\n".join(stamps)

    def files(self) -> list[Path]:
        """Return the run's files, with `run.json` last."""
        check_folder(self.path)
        files = sorted(file for file in self.path.rglob("*") if file.is_file())
        return sorted(files, key=lambda file: file.name == "run.json")

    def viewer_file(self, name: str) -> Path:
        """Return the path of a file that the viewer makes for all runs of the sweep; it may be deleted."""
        return self.path.parent.parent / "viewer" / name

    def forget_failure(self) -> None:
        """If the run has failed, remove `run.json`, so that the run can be played again."""
        summary = self.summary()
        if summary is not None and summary.status != "complete":
            self._end_file.unlink()

    def claim(self) -> AbstractContextManager[bool]:
        """Reserve the run for this process, until it ends or crashes; yield False if another process has the run."""
        return claimed(self._sweep_path / "locks" / f"{self.id}.lock")


@contextlib.contextmanager
def claimed(lock_path: Path, wait_s: float = 0.0) -> Iterator[bool]:
    """Hold a lock within this context; yield False if another process holds it. A crash of the process frees the lock.

    Args:
        lock_path: file of the lock.
        wait_s: time to wait for another process, seconds.
    """
    from filelock import FileLock, Timeout  # readers need no lock

    lock = FileLock(lock_path, timeout=wait_s)
    try:
        lock_path.parent.mkdir(parents=True, exist_ok=True)
        lock.acquire()
    except Timeout:
        yield False
        return
    except OSError as error:
        raise cannot_write(lock_path, error) from error
    try:
        yield True
    finally:
        lock.release()


def _content(path: Path) -> bytes | None:
    try:
        return plain(path).read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise RecordError(f"{path} cannot be read: {error}") from error


def sha256_of(content: bytes) -> str:
    """Return the SHA-256 of a content as hexadecimal digits."""
    return hashlib.sha256(content).hexdigest()


def whole_lines(content: bytes) -> bytes:
    """Return the complete lines; a last line without a line break is left out, because a crash cut it."""
    return content[: content.rfind(b"\n") + 1]


def lines_of(content: bytes, kind: type[T], where: object) -> list[T]:
    """Return the value of each line of a JSON Lines file; an error names the file `where`."""
    try:
        return msgspec.json.Decoder(kind).decode_lines(content)
    except NOT_JSON as error:
        raise RecordError(f"{where} cannot be read: {error}") from error


def last_whole_step(numbers: Sequence[int], *, complete: bool) -> int:
    """Return the number of the last step that has all its lines; 0 if there is none.

    Args:
        numbers: step number of each line of `steps.jsonl`, in order.
        complete: whether the run is complete. If not, a crash may have cut its last step. A last step that has as many
            lines as the first one is whole.
    """
    if not numbers:
        return 0
    whole = complete or numbers.count(numbers[-1]) == numbers.count(numbers[0])
    return numbers[-1] if whole else numbers[-1] - 1


def json_file(path: Path, kind: type[T]) -> T | None:
    """Return the value in a JSON file, or None if the file does not exist."""
    content = _content(path)
    if content is None:
        return None
    try:
        return msgspec.json.decode(content, type=kind)
    except NOT_JSON as error:
        raise RecordError(f"{path} cannot be read: {error}") from error


def read_calls(path: Path) -> Iterator[Call]:
    """Yield the complete calls in a log, or nothing if no such file exists. A crash may have cut the last call."""
    if not is_there(path):
        return
    decode = msgspec.json.Decoder(Call).decode
    with path.open("rb") as file, zstandard.ZstdDecompressor().stream_reader(file, read_across_frames=True) as reader:
        try:
            yield from (decode(line) for line in _whole_lines(reader))
        except NOT_JSON as error:
            raise RecordError(f"{path} cannot be read: {error}") from error


def count_call(counts: Counts, call: Call) -> None:
    """Add a call to the counts, with its retries and tokens; an answer of foundry's cache has no retries of its own."""
    counts.calls += 1
    counts.cached += call.cached
    counts.retries += 0 if call.cached else len(call.attempts)
    counts.add_tokens(call)


def calls_bytes(calls: Iterable[Call]) -> bytes:
    """Return the content of a log of calls (`calls.jsonl.zst`)."""
    return zstandard.ZstdCompressor(level=3).compress(b"".join(_ENCODE(call) + b"\n" for call in calls))


def _whole_lines(reader: Any) -> Iterator[bytes]:
    rest = b""
    while True:
        try:
            chunk = reader.read(_READ_AT_ONCE)
        except zstandard.ZstdError:
            return
        if not chunk:
            return
        *lines, rest = (rest + chunk).split(b"\n")
        yield from lines


def frame_name(step: int) -> str:
    """Return the name, within the run's folder, of the picture of the state after a step; step 0 is the start."""
    return f"frames/step_{step:04d}.png"


def stored_picture(run: Path, name: str) -> bytes | None:
    """Return the content of a picture, given its name in the records, or None if it was not stored."""
    try:
        for part in list(PurePath(name).parents)[-2::-1]:
            plain(run / part)
        file = plain(run / name).resolve(strict=True)
        inside = file.is_relative_to(run.resolve())
        content = file.read_bytes() if inside else b""
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise RecordError(f"The picture {name!r} of {run.name} cannot be read: {error}") from error
    if not inside:
        raise RecordError(f"The picture {name!r} of {run.name} is refused: it is not in the run's folder.")
    return content
