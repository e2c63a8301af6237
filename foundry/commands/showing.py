"""Analyses sweeps, and prints the findings or, as JSON, the tables."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec

from foundry.commands.printing import bars, console, is_verbose, only_json, print_json, say
from foundry.errors import InputError
from foundry.running.cores import multiply_in_one_thread
from foundry.storing.store import SweepFolder

if TYPE_CHECKING:
    from analysis.probes import ProbeAnalysis

_TABLES = (
    "runs", "comparison", "contrasts", "variance", "retest", "equal_chances", "thresholds", "validation",
)  # fmt: skip
"""Names of the tables that the JSON output of an analysis contains. Each table is a list of rows."""


def analyze_and_show(folders: Sequence[Path], *, printed: int = 0, **options: Any) -> None:
    """Analyse sweeps with options of `analysis.analyze`, and print the findings.

    Args:
        folders: folders of the sweeps.
        printed: number of lines that the command has already printed.
        options: options of `analysis.analyze`.
    """
    multiply_in_one_thread()
    from analysis import analyze as analyze_folders

    probe = probe_in(folders, options)  # refuses other folders before a bar appears
    with _watched() as watch:
        analysis = _probe(probe, options) or analyze_folders(folders, watch=watch, **options)
        _prepare(folders)
    for line in analysis.ending(folders, console().width, printed):
        print(line)
    if is_verbose():
        for file in analysis.written:
            say(f"wrote {file}")


def analyze_and_print(folders: Sequence[Path], **options: Any) -> None:
    """Analyse sweeps with options of `analysis.analyze`, and print all tables as one JSON object."""
    multiply_in_one_thread()
    from analysis import analyze as analyze_folders

    with only_json(True):
        probe = _probe(probe_in(folders, options), options)
        analysis: Any = probe or analyze_folders(folders, **options)
    _prepare(folders)
    frames = (
        {**probe.frames, "contrasts": probe.contrasts} if probe else {name: getattr(analysis, name) for name in _TABLES}
    )
    tables = {name: frame.to_dict("records") for name, frame in frames.items()}
    said = {"path": analysis.path, "summary": analysis.summary, "findings": msgspec.to_builtins(analysis.findings)}
    if probe is None:
        said |= {"declared": analysis.declared}
    print_json({**said, **tables, "notes": analysis.notes, "written": analysis.written})


def _prepare(folders: Sequence[Path]) -> None:
    from foundry.viewer.forms import prepare

    for folder in folders:
        prepare(SweepFolder.open(folder))


def _probe(probe: SweepFolder | None, options: Mapping[str, Any]) -> ProbeAnalysis | None:
    if probe is None:
        return None
    from analysis.probes import analyze_probe  # it draws plots, which other analyses do only on request

    filters = {name: options.get(name, ()) for name in ("only", "without")}
    return analyze_probe(probe, options.get("family") or (), **filters)


def probe_in(folders: Sequence[Path], options: Mapping[str, Any]) -> SweepFolder | None:
    """Return the sweep of a probe, or None if none of the folders is a probe."""
    from analysis.load import is_probe

    opened = [SweepFolder.open(folder) for folder in folders]
    if not any(map(is_probe, opened)):
        return None
    if len(opened) > 1:
        raise InputError(f"One of {len(opened)} folders is a probe. Analyse a probe alone: foundry analyze FOLDER.")
    if any(value for name, value in options.items() if name not in ("family", "only", "without")):
        raise InputError(f"'{folders[0]}' is a probe, which takes no margins, labels or --plots. Leave them out.")
    return opened[0]


@contextlib.contextmanager
def _watched() -> Iterator[Callable[[int, int], None] | None]:
    """Yield a function that shows how many runs have been measured; yield None if the output is no terminal."""
    screen = bars()
    if screen.quiet or not screen.is_terminal:
        yield None
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    with Progress("measuring", BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), transient=True) as shown:
        task = shown.add_task("measuring")
        yield lambda done, total: shown.update(task, completed=done, total=total)
