"""The command that turns sweeps into tables and plots."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from foundry.commands.application import app, console


@app.command()
def analyze(
    folders: Annotated[list[Path], typer.Argument(help="Sweep folders.", show_default=False)],
) -> None:
    """Compute the signatures of every run, compare the models, draw the plots."""
    analyze_and_show(folders)


def analyze_and_show(folders: Sequence[Path]) -> None:
    """Analyse sweeps and print the short table."""
    from analysis import analyze as analyze_folders
    from foundry.display import frame_table

    analysis = analyze_folders(folders)
    headline = analysis.headline()
    console().print(frame_table(headline.rows, headline.columns))
    for note in analysis.notes:
        print(note)
    print(f"tables and plots in {analysis.path}")
