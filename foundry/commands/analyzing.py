"""The command that turns sweeps into tables and plots."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from foundry.commands.application import EXIT_OK, Mine, Trusted, app
from foundry.commands.showing import analyze_and_show
from foundry.commands.sweeps import run_baselines
from foundry.errors import InputError


class Labeller(StrEnum):
    """Who says which messages are warnings."""

    RULE = "rule"
    MODEL = "model"


Folders = Annotated[list[Path], typer.Argument(help="Sweep folders.", show_default=False)]
WhoLabels = Annotated[
    Labeller, typer.Option(help="Who says which messages are warnings: the rule, or the model of foundry label.")
]
Family = Annotated[
    list[str] | None,
    typer.Option(help="A measure that claims rest on, declared beforehand; may be given several times."),
]
Margins = Annotated[
    list[str] | None,
    typer.Option(help="MEASURE=SIZE: the difference below which models count as the same; declared beforehand."),
]


@app.command()
def analyze(
    folders: Folders,
    baselines: Annotated[
        bool, typer.Option("--baselines", help="First run the scripted baselines on the same worlds and seeds.")
    ] = False,
    labeller: WhoLabels = Labeller.RULE,
    family: Family = None,
    margin: Margins = None,
    trust_targets: Trusted = None,
    config_dir: Mine = None,
) -> None:
    """Compute the signatures of every run, compare the models, draw the plots."""
    margins = margins_of(margin or [])
    codes = [run_baselines(folder, trust_targets or ()) for folder in folders] if baselines else []
    by_model = labeller is Labeller.MODEL
    analyze_and_show(folders, labelled_by_model=by_model, family=family, margins=margins)
    raise typer.Exit(max(codes, default=EXIT_OK))


def margins_of(texts: Sequence[str]) -> dict[str, float]:
    """Return the margins of equivalence by measure.

    Raises:
        InputError: one does not have the form MEASURE=SIZE, or a measure has two.
    """
    margins = {}
    for text in texts:
        measure, _, size = text.rpartition("=")
        if measure in margins:
            raise InputError(f"--margin {measure} is given twice: give each measure one margin.")
        try:
            margins[measure] = float(size)
        except ValueError:
            raise InputError(
                f"--margin {text} has not the form MEASURE=SIZE, such as clustering.largest_group=0.1"
            ) from None
    return margins
