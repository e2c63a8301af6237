"""Writes the page and the records as a folder of files that a browser opens without a server."""

import base64
import gzip
import itertools
import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import msgspec

from foundry.errors import InputError
from foundry.storing.notes import Notes
from foundry.storing.store import RunFolder
from foundry.viewer.catalog import ROWS_PER_PAGE, CatalogedSweep
from foundry.viewer.files import PALETTE, ROOMS, STATIC, inside, palette_script
from foundry.viewer.forms import outside_script
from foundry.viewer.resources import Resources, addresses_of_run, resources_of_agents
from foundry.viewer.run_view import IsWarning

DECISIONS_PER_CHUNK = 50
"""Number of steps in each exported file with decisions of an agent; a larger number gives fewer but larger files."""
_ENCODE = msgspec.json.Encoder().encode
_NOT_COPIED = ("source_http.js", "source_files.js")


@dataclass(frozen=True)
class Exported:
    """The result of an export: the file to open, the numbers of runs and files, and the size in bytes."""

    page: Path
    runs: int
    files: int
    size: int


def export(
    root: Path,
    out: Path,
    trusted: Sequence[str] = (),
    *,
    notes: bool = False,
    is_warning: IsWarning | None = None,
) -> Exported:
    """Write the page of a sweep, or of a folder of sweeps, into a new folder.

    Args:
        root: the sweep's folder, or the folder of sweeps.
        out: the folder to write to.
        trusted: see `Resources`.
        notes: whether the export contains the notes of people; they cannot be changed in it.
        is_warning: see `Resources`.

    Raises:
        InputError: there is no sweep, or the target folder contains files.
    """
    resources = Resources(root, decisions_per_chunk=DECISIONS_PER_CHUNK, trusted=trusted, is_warning=is_warning)
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise InputError(f"'{out}' already contains files. Name a new or an empty folder for the export.")
    shutil.copytree(STATIC, out, ignore=shutil.ignore_patterns(*_NOT_COPIED), dirs_exist_ok=True)
    for room, folder in ROOMS.items():
        shutil.copytree(folder, out / room)
    shutil.copyfile(STATIC / "source_files.js", out / "source.js")
    (out / PALETTE).write_bytes(palette_script())
    runs = 0
    try:
        _write(out, "sweeps", resources.get("sweeps").content)
        for sweep in resources.catalog.sweeps():
            runs += _export_sweep(resources, sweep, out)
            noted = resources.get(f"sweep/{sweep.id}/notes").content if notes else _ENCODE(Notes([], []))
            _write(out, f"sweep/{sweep.id}/notes", noted)
    finally:
        resources.close()
    files = [path for path in out.rglob("*") if path.is_file()]
    return Exported(out / "index.html", runs, len(files), sum(path.stat().st_size for path in files))


def _export_sweep(resources: Resources, sweep: CatalogedSweep, out: Path) -> int:
    for address in _addresses_of_sweep(sweep):
        _write(out, address, resources.get(address).content)
    for address, resource in resources.probe(sweep.id).exports() if sweep.is_probe else ():
        _write(out, f"probe/{sweep.id}/{address}", resource.content)
    for link in sweep.head()["links"]:
        _copy(sweep, link["path"], out)
    for folder in sweep.runs():
        _export_run(resources, sweep, folder, out)
    return len(sweep.runs())


def _export_run(resources: Resources, sweep: CatalogedSweep, folder: RunFolder, out: Path) -> None:
    view, run = resources.view(sweep.id, folder.id), f"run/{sweep.id}/{folder.id}"
    for part in addresses_of_run(view):
        _write(out, f"{run}/{part}", resources.get(f"{run}/{part}").content)
    for part, resource in itertools.chain(resources_of_agents(view), view.exports()):
        _write(out, f"{run}/{part}", resource.content)
    for file in view.files():
        _copy(sweep, file, out)
    script = outside_script(folder.declared.form)  # shipped scripts are part of the page
    if script is not None:
        _copy_file(script.file, out / script.address)


def _addresses_of_sweep(sweep: CatalogedSweep) -> Iterator[str]:
    yield from (f"sweep/{sweep.id}", f"sweep/{sweep.id}/groups")
    yield from (f"sweep/{sweep.id}/rows/{page}" for page in range(-(-len(sweep.runs()) // ROWS_PER_PAGE)))
    yield from (f"sweep/{sweep.id}/measure/{index}" for index in range(len(sweep.measures())))
    yield from (f"sweep/{sweep.id}/partings/{first.id}/{second.id}" for first, second in _paired_runs(sweep))


def _paired_runs(sweep: CatalogedSweep) -> Iterator[tuple[RunFolder, RunFolder]]:
    """Yield every pair of runs with the same world and the same seed; the run with the lower id comes first."""
    worlds = [condition.config["world"]["name"] for condition in sweep.folder.sweep.conditions]
    runs = zip(sweep.folder.sweep.runs, sweep.runs(), strict=True)
    placed = sorted((worlds[run.condition], run.seed, run.id, folder) for run, folder in runs)
    for _, same in itertools.groupby(placed, key=lambda pair: pair[:2]):
        yield from itertools.combinations([folder for *_, folder in same], 2)


def _copy(sweep: CatalogedSweep, relative: str, out: Path) -> None:
    _copy_file(inside(sweep.folder.path, relative), out / "files" / sweep.id / relative)


def _copy_file(source: Path | None, target: Path) -> None:
    if source is not None:
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, target)


def _write(out: Path, address: str, content: bytes) -> None:
    """Write data of the page as a script that passes them to the page. In base64, no recorded text can act as code."""
    packed = base64.b64encode(gzip.compress(content, 6, mtime=0)).decode()
    target = out / "data" / f"{address}.js"
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(f'"use strict";Foundry.received("{address}","{packed}");\n', encoding="ascii")
