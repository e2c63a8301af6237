"""The command that turns sweeps into tables and plots."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from foundry.commands.application import EXIT_INTERRUPTED, EXIT_OK, Trusted, app
from foundry.commands.showing import analyze_and_show
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


def run_baselines(path: Path, trusted: Sequence[str] = ()) -> int:
    """Run the scripted baselines of a sweep into the folder beside its runs; those that are there stay.

    Returns:
        The exit code: that of a sweep in which a run failed, or which was stopped, where that happened.

    Raises:
        typer.Exit: the user interrupted them.
    """
    from foundry.commands.sweeps import run_folder, runner_of
    from foundry.composing.baselines import baselines_of
    from foundry.composing.preflight import check
    from foundry.storing.store import SweepFolder
    from foundry.trust.targets import check_sweep_targets

    opened = SweepFolder.open(path)
    check_sweep_targets(opened.sweep, {}, trusted)
    sweep = baselines_of(opened.sweep)
    if not sweep.runs:
        print(f"{path} compares every baseline itself")
        return EXIT_OK
    local = {"_target_": "foundry.running.local.LocalRunner"}
    settings = {"runner": local, "cache": {"path": ""}, "analyze": False, "view": None, "record": {"frames": 0}}
    folder = SweepFolder.create(opened.baselines_dir, sweep, settings, [])
    code = run_folder(folder, settings, check(sweep), runner_of(settings))
    if code == EXIT_INTERRUPTED:
        raise typer.Exit(code)
    return code
