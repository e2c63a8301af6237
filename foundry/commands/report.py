"""The command that writes the report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from foundry.commands.analyzing import Family, Folders, Labeller, Margins, WhoLabels, margins_of
from foundry.commands.application import Mine, app


@app.command()
def report(
    folders: Folders,
    out: Annotated[
        Path | None, typer.Option(help="The page; by default report.html in the first sweep's folder.")
    ] = None,
    labeller: WhoLabels = Labeller.RULE,
    family: Family = None,
    margin: Margins = None,
    config_dir: Mine = None,
) -> None:
    """Write one page with everything about the sweeps, for a browser without a network."""
    from analysis.report import write_report

    by_model, margins = labeller is Labeller.MODEL, margins_of(margin or [])
    written = write_report(folders, out, labelled_by_model=by_model, family=family, margins=margins)
    print(f"report of {written.runs} runs in {written.path}; its pictures in {written.pictures}")
