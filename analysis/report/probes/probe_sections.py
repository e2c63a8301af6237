"""The sections of a probe's page: questions, findings, limits and commands."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from analysis.lines import COMPLETE
from analysis.probes import ProbeAnalysis, analyze_probe
from analysis.probes.comparing import ALL
from analysis.probes.differences import unread_of
from analysis.probes.probe_pictures import pictures_of
from analysis.prose import percent
from analysis.report import Report, check_out, write_page
from analysis.report.grids import Grid, grid, grid_of
from analysis.report.probes.probe_first import first_screen
from analysis.report.probes.probe_moments import MomentSource, furthest
from analysis.report.provenance import commands_of, determinism_grid
from analysis.report.sections import shapes
from analysis.report.templating import rendered
from foundry.storing.store import SweepFolder


def write_probe_report(
    folder: SweepFolder,
    looked: MomentSource,
    out: Path | None = None,
    family: Sequence[str] = (),
    *,
    only: Sequence[str] = (),
    without: Sequence[str] = (),
) -> Report:
    """Analyse a probe and write its page, by default `report.html` in its folder.

    Raises:
        InputError: a declared or filtered name is not in the probe, or the page cannot be written.
        RecordError: a recorded file is damaged.
    """
    check_out(out)
    analysis = analyze_probe(folder, family, only=only, without=without, plots=False)
    path, pictures = out or folder.report_file, analysis.path / "plots"
    drawn = shapes(pictures_of(analysis.frames, analysis.contrasts), pictures, path.resolve().parent)
    write_page(path, rendered("probe.html", _content(folder, analysis, looked) | {"shapes": drawn}))
    ends = [run.summary() for run in folder.runs()]
    complete = sum(end is not None and end.status == COMPLETE for end in ends)
    return Report(path, len(ends), complete, pictures, (folder,) if complete < len(ends) else ())


def _content(folder: SweepFolder, analysis: ProbeAnalysis, looked: MomentSource) -> dict[str, Any]:
    return {
        "title": folder.path.resolve().name,
        **first_screen(folder, analysis, looked),
        "summary": analysis.summary,
        "moments": furthest(looked, analysis.furthest),
        "limits": [*analysis.notes, *limits(analysis.frames)],
        "unread": unread_grid(analysis.frames["moments"]),
        "determinism": determinism_grid([folder]),
        "tables": [(table.name, grid_of(table)) for table in analysis.tables],
        "asked": commands_of([folder]),
    }


def limits(frames: Mapping[str, pd.DataFrame]) -> Iterator[str]:
    """Yield a line for each edit that leaves some moments unchanged."""
    edits = frames["edits"][frames["edits"]["kind"] == ALL]
    for edit, rows in edits.groupby("edit", sort=False):
        asked, changed = int(rows["asked"].max()), int(rows["moments"].max())
        if changed < asked:
            yield f"{edit} changes nothing in {asked - changed} of {asked} moments; its numbers omit these moments."


def unread_grid(moments: pd.DataFrame) -> Grid:
    """Return a row per model, edit and format with the share of unreadable answers."""
    asked = ("model", "edit", "format")
    rows = [
        (*(str(sums[name]) for name in asked), f"{sums['answers']:,}", f"{sums['unread']:,}",
         percent(sums["unread"] / sums["answers"]))
        for sums in unread_of(moments).reset_index().to_dict("records")
    ]  # fmt: skip
    columns = (*asked, "answers", "unread", "share")
    return grid("Number of answers, and of answers without a readable decision.", columns, rows)
