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
from foundry.viewer.partings import paired_runs
from foundry.viewer.resources import Resources, addresses_of_run, resources_of_agents
from foundry.viewer.run_view import IsWarning

DECISIONS_PER_CHUNK = 50
"""Number of steps of an agent per file, so that there are few files of moderate size."""
_ENCODE = msgspec.json.Encoder().encode
_NOT_COPIED = ("source_http.js", "source_files.js")


@dataclass(frozen=True)
class Exported:
    """The result of an export.

    Attributes:
        page: the file to open.
        runs: number of runs.
        files: number of files.
        size: bytes.
    """

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
        trusted: further packages from which worlds' classes may come, for redrawing pictures.
        notes: whether to include people's notes, read-only.
        is_warning: returns whether a text warns of fires with the given names, for the reach of warnings; None if
            unknown.

    Raises:
        InputError: there is no sweep, or the target folder contains files.
        RecordError: a record cannot be read.
    """
    resources = Resources(root, decisions_per_chunk=DECISIONS_PER_CHUNK, trusted=trusted, is_warning=is_warning)
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise InputError(f"'{out}' contains files. Name a new or an empty folder for the export.")
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
    _copy_script(folder.declared.form, out)


def _addresses_of_sweep(sweep: CatalogedSweep) -> Iterator[str]:
    yield from (f"sweep/{sweep.id}", f"sweep/{sweep.id}/groups")
    yield from (f"sweep/{sweep.id}/rows/{page}" for page in range(-(-len(sweep.runs()) // ROWS_PER_PAGE)))
    yield from (f"sweep/{sweep.id}/measure/{index}" for index in range(len(sweep.measures())))
    yield from (f"sweep/{sweep.id}/partings/{first.id}/{second.id}" for first, second in paired_runs(sweep))


def _copy(sweep: CatalogedSweep, relative: str, out: Path) -> None:
    source = inside(sweep.folder.path, relative)
    if source is not None:
        target = out / "files" / sweep.id / relative
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, target)


def _copy_script(form: str, out: Path) -> None:
    """Copy the script of a user's form; shipped scripts are part of the page."""
    script = outside_script(form)
    if script is not None:
        target = out / script.address
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(script.file, target)


def _write(out: Path, address: str, content: bytes) -> None:
    """Write a resource as a script; base64 prevents texts of records from acting as script code."""
    packed = base64.b64encode(gzip.compress(content, 6, mtime=0)).decode()
    target = out / "data" / f"{address}.js"
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(f'"use strict";Foundry.received("{address}","{packed}");\n', encoding="ascii")
