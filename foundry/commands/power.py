"""The command that says how many seeds a sweep needs."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from typing import TYPE_CHECKING, Annotated

import typer

from foundry.commands.application import Folder, app, console
from foundry.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

_COLUMNS = ("measure", "contrast", "pairs", "sd", "difference", "alone", "in the family", "cautious", "note")


@app.command()
def power(
    folder: Folder,
    difference: Annotated[
        float | None, typer.Option(help="What is to be found, in the unit of the measure; else what the pilot shows.")
    ] = None,
    power: Annotated[float, typer.Option(help="Probability to find it.")] = 0.8,
    measure: Annotated[
        str | None, typer.Option(help="One measure, such as idle_rate.chosen; else the headlines.")
    ] = None,
) -> None:
    """Say how many seeds a sweep needs, judged by a pilot sweep."""
    from foundry.display import frame_table

    plan = _plan(folder, difference, power, measure)
    if plan.empty:
        raise InputError(f"{folder} has no two conditions to compare: a pilot needs two models, or two prompts.")
    family = int(plan["family"].max())
    console().print(frame_table([_row(one) for one in plan.to_dict("records")], _COLUMNS))
    print(f"seeds for {power:.0%} power at .05: alone, as one of {family} tests (Holm), and with the upper 80 % bound")
    print("of the pilot's sd; a pilot of few seeds knows its sd badly, so plan with the last")


def _plan(folder: Folder, difference: float | None, target: float, measure: str | None) -> pd.DataFrame:
    from analysis.groups import group_columns
    from analysis.stats.power import power as plan
    from analysis.table import Source, build_table, measure_run
    from foundry.storing.store import SweepFolder

    source = Source(folder, folder.name)
    results = [measure_run(run, source).without_steps() for run in SweepFolder.open(folder).runs()]
    table = build_table(results)
    if not table.frame["status"].eq("complete").any():
        raise InputError(f"{folder} has no complete run to judge by: foundry resume {folder} goes on with it.")
    return plan(table, group_columns(results, table), measure=measure, difference=difference, target=target)


def _row(one: Mapping[Hashable, object]) -> tuple[str, ...]:
    contrast = f"{one['level']} - {one['reference']}" + (f" ({one['context']})" if one["context"] else "")
    numbers = [_number(one[name], ".3g") for name in ("sd", "difference")]
    seeds = [_number(one[name], ".0f") for name in ("n_alone", "n_family", "n_cautious")]
    return (str(one["measure"]), contrast, str(one["n_pairs"]), *numbers, *seeds, str(one["note"]))


def _number(value: object, form: str) -> str:
    return format(value, form) if isinstance(value, float) and not math.isnan(value) else "-"
