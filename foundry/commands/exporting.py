"""The command that writes sweeps for other tools."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from foundry.commands.analyzing import Family
from foundry.commands.application import LOOK, Folder, Mine, app, for_screen, say
from foundry.errors import InputError

if TYPE_CHECKING:
    from foundry.exporting.scores import Measured, Scores
    from foundry.storing.store import SweepFolder


class Format(StrEnum):
    """What a sweep can be exported as."""

    INSPECT = "inspect"
    EEE = "eee"


@app.command(rich_help_panel=LOOK)
def export(
    what: Annotated[
        Format,
        typer.Argument(
            help="inspect: logs of Inspect; eee: records of Every Eval Ever; one a condition.", show_default=False
        ),
    ],
    folder: Folder,
    out: Annotated[
        Path | None, typer.Argument(help="A new or an empty folder; else in the sweep's analysis.", show_default=False)
    ] = None,
    family: Family = None,
    config_dir: Mine = None,
) -> None:
    """Write a sweep for other tools: runs, calls and declared measures, without what says where it was run."""
    from foundry.exporting.writing import write
    from foundry.storing.store import SweepFolder

    sweep = SweepFolder.open(folder)
    written = write(what.value, sweep, out, scores_of(sweep, family))
    for note in written.notes:
        print(for_screen(note))
    say(for_screen(f"{len(written.files)} files with {written.runs} runs in {written.path}"))


def scores_of(sweep: SweepFolder, family: Sequence[str] | None) -> Scores:
    """Return the declared measures of a sweep's runs: of the family, else of what was declared before the runs.

    A probe has none: what is chosen in moments of many runs is compared by moment; a mean over its runs says nothing.

    Raises:
        InputError: a measure of the family does not exist or the sweep is a probe, or a user's own code cannot be used.
        RecordError: a recorded file is damaged.
    """
    import pandas as pd

    from analysis.load import is_probe
    from analysis.measuring.runs import Source, measure_run
    from analysis.pipeline import check_declared
    from analysis.stats.family import declared_measures
    from analysis.tables.comparison import compare
    from analysis.tables.signature_table import build_table
    from foundry.exporting.scores import Mean, Scores
    from foundry.storing.preregistration import preregistration_of

    if is_probe(sweep):
        if family:
            raise InputError(f"'{sweep.path}' is a probe, which is compared by moment: leave --family out.")
        return Scores((), {}, {})
    check_declared([sweep], family, None)
    runs, source = sweep.runs(), Source(sweep.path, sweep.path.name)
    table = build_table([measure_run(run, source).without_steps() for run in runs])
    compared = compare(table, pd.DataFrame({"condition": [run.run.condition for run in runs]}))
    planned = preregistration_of(sweep.path)
    asked = family or (None if planned is None else [one.name for one in planned[0].measures])
    names = declared_measures(asked, table.measures, table.present)
    means: dict[int, dict[str, Mean]] = {}
    for (name, (condition,)), one in compared.estimates.items():
        if name in names:
            means.setdefault(int(condition), {})[name] = Mean(one.n, one.mean, one.sd, one.low, one.high, one.interval)
    rows = zip(table.frame["run"], table.present, table.frame[list(names)].to_dict("records"), strict=True)
    of_runs = {run: {name: row[name] for name in names if name in present} for run, present, row in rows}
    return Scores(tuple(map(_measured, names)), of_runs, means)


def _measured(name: str) -> Measured:
    from analysis.signatures import describe
    from foundry.exporting.scores import Measured

    found = describe(name)
    return Measured(name, found.label, found.low, found.high, str(found.null or ""), found.better)
