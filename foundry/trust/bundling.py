"""Packs a sweep into a bundle, one file for a reviewer; the same sweep always gives the same bytes."""

import hashlib
import io
import os
import shutil
import tarfile
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path, PurePosixPath
from typing import IO, Any

import msgspec
import zstandard

from foundry import provenance
from foundry.errors import InputError
from foundry.expansion import Sweep
from foundry.labels.folder import label_files_of
from foundry.records import Call
from foundry.storing.determinism import DETERMINISM_FILE
from foundry.storing.notes import NOTES_FILE, notes_bytes, notes_of
from foundry.storing.plain import check_folder
from foundry.storing.preregistration import LOOKS_FILE, PREREGISTRATION_FILE
from foundry.storing.run_files import sha256_of
from foundry.storing.store import (
    SCENES_FILE,
    RunFolder,
    SweepFolder,
    calls_bytes,
    ensure_writable,
    read_calls,
    stored_picture,
)
from foundry.storing.sweep_file import sweep_text, to_yaml
from foundry.trust.manifest import FORMAT, NAME, BundledFile, Manifest, check_names
from foundry.trust.privacy import Scrubber

LEVEL = 10
_OTHER_FORMATS = {".zip", ".7z", ".rar", ".gz", ".tgz", ".bz2", ".xz"}
CITATION = "CITATION.cff"
NEUTRAL = {
    "output": {"dir": None},
    "cache": {"path": "outputs/answers.sqlite"},
    "runner": {"_target_": "foundry.running.local.LocalRunner", "workers": None, "open_runs": 16, "ahead": True},
}
"""The settings in a bundle for running the sweep, which replace the settings of this machine."""


@dataclass(frozen=True)
class BundledScene:
    """A scene with all files that it needs.

    Attributes:
        asset: name of the scene in the configuration.
        main: path of its main file in the bundle.
        files: all its files, by their paths in the bundle.
    """

    asset: str
    main: str
    files: Mapping[str, Path]


def scenes_of(folder: SweepFolder) -> list[BundledScene]:
    """Return the scenes in which the runs of a sweep take place."""
    scenes: dict[str, BundledScene] = {}
    for condition, here in zip(folder.sweep.conditions, folder.sweep_here().conditions, strict=True):
        scene = condition.config["world"].get("scene")
        if isinstance(scene, Mapping) and isinstance(asset := scene.get("asset"), str) and asset not in scenes:
            scenes[asset] = _scene(asset, here.config["world"]["scene"])
    return list(scenes.values())


def _scene(asset: str, here: Mapping[str, Any]) -> BundledScene:
    """Return a scene with all its files, which must be in one folder, by default the folder of its main file."""
    from foundry.worlds.camera.loading.scene_files import find_asset, scene_files

    main = find_asset(here["asset"]).resolve()
    limit = Path(here["root"]).resolve() if here.get("root") else main.parent
    files = [file for file in scene_files(main) if file == main or file.is_relative_to(limit)]
    root = Path(os.path.commonpath([file.parent for file in files]))
    if len(files) > 1:
        _check_movable(asset, root, main, files)
    digest = hashlib.sha256()
    for file in files:
        digest.update(hashlib.sha256(file.read_bytes()).digest())
    top = PurePosixPath("scenes") / digest.hexdigest()[:16]
    return BundledScene(
        asset=asset,
        main=str(top / main.relative_to(root).as_posix()),
        files={str(top / file.relative_to(root).as_posix()): file for file in files},
    )


def _check_movable(asset: str, root: Path, main: Path, files: list[Path]) -> None:
    """Copy a scene to another folder, and raise an error if the copy still needs files outside or misses files."""
    from foundry.worlds.camera.loading.scene_files import scene_files

    with tempfile.TemporaryDirectory() as name:
        copy = Path(name).resolve()
        for file in files:
            target = copy / file.relative_to(root)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target)
        copied = scene_files(copy / main.relative_to(root))
    lost = [file for file in copied if not file.is_relative_to(copy)]
    if lost or len(copied) < len(files):
        what = f"'{lost[0]}'" if lost else "a file"
        raise InputError(
            f"Scene '{asset}' names {what} by an absolute path. To bundle the sweep, make this path relative."
        )


@dataclass(frozen=True)
class Entry:
    """A file of a bundle: its path in the bundle, and a function that returns its content."""

    name: str
    read: Callable[[], bytes]


def write_bundle(path: Path, out: Path, *, notes: bool = False) -> Manifest:
    """Write the bundle of the sweep in a folder; `notes` says whether people's notes are included."""
    if out.suffix.lower() in _OTHER_FORMATS:
        raise InputError(f"A bundle is a .tar.zst file, not a {out.suffix} file. Use '{out.with_suffix('.tar.zst')}'.")
    if out.exists():
        raise InputError(f"'{out}' already exists. Name another file, or remove it.")
    folder, scrubber = SweepFolder.open(path), Scrubber()
    entries = sorted(_entries(folder, scrubber, "", notes=notes), key=lambda entry: entry.name)
    try:
        check_names(entry.name for entry in entries)
    except InputError as error:
        raise InputError(f"Cannot bundle '{path}': {error}") from error
    manifest = Manifest(
        format=FORMAT,
        sweep=path.resolve().name,
        runs=len(folder.sweep.runs),
        versions=provenance.versions(),
        git_commit=provenance.git_commit(),
        files=tuple(_described(entry) for entry in entries),
    )
    ensure_writable(out.parent)
    partial_file = out.with_name(f".{out.name}.part")
    try:
        with partial_file.open("wb") as file:
            _write(file, manifest, entries)
        partial_file.replace(out)
    finally:
        partial_file.unlink(missing_ok=True)
    return manifest


def _described(entry: Entry) -> BundledFile:
    content = entry.read()
    return BundledFile(path=entry.name, size=len(content), sha256=sha256_of(content))


def _write(file: IO[bytes], manifest: Manifest, entries: Sequence[Entry]) -> None:
    first = msgspec.json.format(msgspec.json.encode(manifest), indent=1) + b"\n"
    compressor = zstandard.ZstdCompressor(level=LEVEL, write_checksum=True)
    with compressor.stream_writer(file, closefd=False) as stream:
        _write_member(stream, NAME, first)
        for entry, described in zip(entries, manifest.files, strict=True):
            content = entry.read()
            if len(content) != described.size:
                raise InputError(f"'{entry.name}' changed during bundling. Wait until the sweep has ended.")
            _write_member(stream, entry.name, content)
        stream.write(b"\0" * (2 * tarfile.BLOCKSIZE))


def _write_member(stream: IO[bytes], name: str, content: bytes) -> None:
    info = tarfile.TarInfo(name)
    info.size, info.mode, info.mtime = len(content), 0o644, 0
    try:
        stream.write(info.tobuf(tarfile.USTAR_FORMAT, "utf-8", "strict"))
    except ValueError as error:
        raise InputError(f"Cannot bundle '{name}': its name or the file is too long ({error}).") from error
    stream.write(content + b"\0" * (-len(content) % tarfile.BLOCKSIZE))


def _entries(folder: SweepFolder, scrubber: Scrubber, prefix: str, *, notes: bool) -> Iterator[Entry]:

    scenes = scenes_of(folder)
    sweep, named = _scrubbed(folder.sweep, scenes, scrubber)
    settings = scrubber.config({**folder.settings, **NEUTRAL})
    models = [scrubber.value(model) for model in folder.models]
    yield _text(f"{prefix}sweep.yaml", partial(sweep_text, sweep, settings, models, folder.plan), scrubber)
    for run in folder.runs():
        yield from _run_entries(run, sweep, scrubber, f"{prefix}runs/{run.id}/")
    for file in sorted((folder.path / "origins").glob("*.jsonl.zst")):
        yield Entry(f"{prefix}origins/{file.name}", partial(_calls, partial(read_calls, file), file.name, scrubber))
    if folder.moments_file.exists():
        yield Entry(f"{prefix}{folder.moments_file.name}", partial(_checked, folder.moments_file, scrubber))
    if scenes:
        content = msgspec.json.encode(dict(sorted(named.items())))
        yield _text(f"{prefix}{SCENES_FILE}", content.decode, scrubber)
    yield from (Entry(prefix + name, file.read_bytes) for scene in scenes for name, file in scene.files.items())
    yield from _label_and_note_entries(folder, scrubber, prefix, notes=notes)
    if not prefix:
        yield _text(CITATION, partial(_citation, folder.path.resolve().name), scrubber)
        if (folder.baselines_dir / "sweep.yaml").exists():
            yield from _entries(SweepFolder.open(folder.baselines_dir), scrubber, "baselines/", notes=notes)


def _label_and_note_entries(folder: SweepFolder, scrubber: Scrubber, prefix: str, *, notes: bool) -> Iterator[Entry]:

    for file in label_files_of(folder):
        yield _text(f"{prefix}{file.relative_to(folder.path).as_posix()}", file.read_text, scrubber)
    for name in (DETERMINISM_FILE, LOOKS_FILE, PREREGISTRATION_FILE):
        if (folder.path / name).exists():
            yield Entry(f"{prefix}{name}", partial(_checked, folder.path / name, scrubber))
    if notes and (noted := notes_of(folder.path).notes):
        yield _text(f"{prefix}{NOTES_FILE}", notes_bytes(noted).decode, scrubber)


def _scrubbed(sweep: Sweep, scenes: Sequence[BundledScene], scrubber: Scrubber) -> tuple[Sweep, dict[str, str]]:
    """Return the sweep without traces of this machine, and the main file of each scene by the scene's name."""
    conditions = tuple(
        replace(condition, config=scrubber.config(condition.config), factors=scrubber.value(dict(condition.factors)))
        for condition in sweep.conditions
    )
    named = {scrubber.text(scene.asset): scene.main for scene in scenes}
    history = tuple(replace(asked, overrides=scrubber.asked(asked.overrides)) for asked in sweep.history)
    return Sweep(scrubber.asked(sweep.asked), conditions, sweep.runs, history), named


def _run_entries(run: RunFolder, sweep: Sweep, scrubber: Scrubber, prefix: str) -> Iterator[Entry]:
    if not run.path.exists():
        return
    check_folder(run.path)
    yield _text(f"{prefix}config.yaml", lambda: to_yaml(sweep.config(run.run)), scrubber)
    if run.ended:
        yield _text(f"{prefix}run.json", partial(_summary, run, scrubber), scrubber)
    for stream in run.streams:
        if run.stream_path(stream).exists():
            yield Entry(f"{prefix}{stream}.jsonl", partial(_checked, run.stream_path(stream), scrubber))
    yield Entry(f"{prefix}calls.jsonl.zst", partial(_calls, run.calls, f"{run.id}/calls.jsonl.zst", scrubber))
    yield from (Entry(f"{prefix}{name}", partial(_picture, run.path, name)) for name in run.pictures())


def _text(name: str, read: Callable[[], str], scrubber: Scrubber) -> Entry:
    def content() -> bytes:
        text = read().encode()
        scrubber.check(name, text)
        return text

    return Entry(name, content)


def _checked(path: Path, scrubber: Scrubber) -> bytes:
    content = path.read_bytes()
    scrubber.check(path.name, content)
    return content


def _picture(run: Path, name: str) -> bytes:
    content = stored_picture(run, name)
    if content is None:
        raise InputError(f"'{name}' disappeared during bundling. Wait until the sweep has ended.")
    return content


def _summary(run: RunFolder, scrubber: Scrubber) -> str:
    summary = scrubber.value(msgspec.to_builtins(run.summary()))
    return msgspec.json.format(msgspec.json.encode(summary), indent=2).decode() + "\n"


def _calls(read: Callable[[], Iterator[Call]], name: str, scrubber: Scrubber) -> bytes:
    calls = [scrubber.call(call) for call in read()]
    scrubber.check(name, b"\n".join(map(msgspec.json.encode, calls)))
    return calls_bytes(calls)


def _citation(name: str) -> str:
    text = io.StringIO()
    text.write("cff-version: 1.2.0\nmessage: Cite this data set and the software that made it.\ntype: dataset\n")
    text.write(to_yaml({"title": f"Recorded sweep {name}", "authors": [{"name": "The authors of this data set"}]}))
    software = {
        "type": "software",
        "title": "foundry",
        "version": provenance.versions()["foundry"],
        "authors": [{"name": "The foundry developers"}],
        "license": "Apache-2.0",
    }
    text.write(to_yaml({"references": [software]}))
    return text.getvalue()
