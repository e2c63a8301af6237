"""The command that writes the report."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from foundry.commands.analyzing import Labeller, margins_of
from foundry.commands.application import app


@app.command()
def report(
    folders: Annotated[list[Path], typer.Argument(help="Sweep folders.", show_default=False)],
    out: Annotated[
        Path | None, typer.Option(help="The page; by default report.html in the first sweep's folder.")
    ] = None,
    labeller: Annotated[
        Labeller, typer.Option(help="Who says which messages are warnings: the rule, or the model of foundry label.")
    ] = Labeller.RULE,
    family: Annotated[
        list[str] | None,
        typer.Option(help="A measure that claims rest on, declared beforehand; may be given several times."),
    ] = None,
    margin: Annotated[
        list[str] | None,
        typer.Option(help="MEASURE=SIZE: the difference below which models count as the same; declared beforehand."),
    ] = None,
) -> None:
    """Write one page with everything about the sweeps, for a browser without a network."""
    from analysis.report import write_report

    by_model, margins = labeller is Labeller.MODEL, margins_of(margin or [])
    written = write_report(folders, out, labelled_by_model=by_model, family=family, margins=margins)
    print(f"report of {written.runs} runs in {written.path}; its pictures in {written.pictures}")
