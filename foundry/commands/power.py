"""The part of `foundry plan` that prints how many seeds a sweep needs, estimated from a pilot."""

from __future__ import annotations

import math
import sys
from collections import defaultdict
from collections.abc import Hashable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from foundry.commands.analyzing import looks_of
from foundry.commands.printing import console, say
from foundry.errors import InputError
from foundry.storing.store import SweepFolder, ensure_writable
from foundry.texts import counted

if TYPE_CHECKING:
    import pandas as pd

    from analysis.filtering import Filter

_MOST_ADVICE = 3
"""Maximum number of pairs of conditions with a recommendation: the pairs that need the most seeds."""
_FIRST = ("measure", "contrast", "pairs", "sd", "difference")
_COLUMNS = (*_FIRST, "alone", "in the family", "cautious", "note")
_AT_LOOKS = (*_FIRST, "power", "seeds", "cautious power", "cautious seeds", "note")
_LOOKS = {"power": ".2f", "seeds": ".1f", "power_cautious": ".2f", "seeds_cautious": ".1f"}


def show_seeds(
    folder: Path,
    *,
    difference: float | None,
    power: float,
    measure: str | None,
    looks: str,
    only: Sequence[str],
    without: Sequence[str],
) -> None:
    """Print how many seeds a sweep or a probe needs, estimated from a pilot in a folder."""
    from analysis.filtering import Filter
    from analysis.load import is_probe
    from analysis.planned.declaring import checked_looks

    wanted, chosen = looks_of(looks), Filter.of(only, without)
    opened = SweepFolder.open(folder)
    if wanted:
        if is_probe(opened):
            raise InputError(f"'{folder}' is a probe, and probes have no interim looks. Leave out --looks.")
        checked_looks(wanted, wanted[-1])
    plan = _plan(opened, difference, power, measure, chosen)
    if plan.empty:
        raise InputError(f"{folder} has only one condition. A pilot needs two models, or two prompts.")
    if chosen:
        say(f"based on a part of the pilot's runs, chosen by: {chosen}")
    shown = plan[plan["declared"]] if plan["declared"].any() else plan
    if wanted:
        _show_looks(shown, wanted)
        return
    _print_rows([_row(row) for row in shown.to_dict("records")], _COLUMNS, left_out=("pairs",))
    _explain(f"alone: number of seeds for {power:.0%} power of one test at level .05, without correction.")
    _explain(f"in the family: number of seeds for {power:.0%} power after correction for {_tests(shown)}.")
    _explain(
        "cautious: as in the family, but with the upper 80 % bound of the pilot's sd. After few seeds, use cautious."
    )
    _write_plan(opened, plan, str(chosen) if chosen else "")
    for line in _recommendations(plan):
        print(_wrapped(line))


def show_labels(folder: Path, name: str, power: float) -> None:
    """Print how many texts people must label to find a difference between two models; estimate this from a pilot."""
    from analysis.labelling.planning import labels_needed
    from foundry.display import frame_table
    from foundry.labels.definition import label_named

    table = labels_needed(SweepFolder.open(folder), label_named(name), power)
    console().print(frame_table(table.rows, table.columns))
    print(table.caption)


def _plan(
    sweep: SweepFolder, difference: float | None, target: float, measure: str | None, chosen: Filter
) -> pd.DataFrame:
    from analysis.load import is_probe
    from analysis.measuring.runs import Source, measure_run
    from analysis.stats.power import power as plan
    from analysis.tables.groups import group_columns
    from analysis.tables.signature_table import build_table

    if is_probe(sweep):
        from analysis.probes.probe_power import probe_power

        return probe_power(sweep, [measure] if measure else [], chosen, difference=difference, target=target)
    source = Source(sweep, sweep.path.name)
    chosen.check(sweep.sweep.conditions)
    results = chosen.taken([measure_run(run, source).without_steps() for run in sweep.runs()])
    table = build_table(results)
    if not table.frame["status"].eq("complete").any():
        raise InputError(f"{sweep.path} has no complete run. Continue it with foundry resume {sweep.path}")
    return plan(table, group_columns(results, table), measure=measure, difference=difference, target=target)


def _write_plan(folder: SweepFolder, plan: pd.DataFrame, filtered: str) -> None:
    from analysis.stats.power import COLUMNS, power_table
    from analysis.tables.texts import write_table

    ensure_writable(folder.analysis_dir)
    first, *_ = write_table(folder.analysis_dir, power_table(plan), plan[list(COLUMNS)], filtered)
    say(f"the whole table, with {len(plan)} rows: {first}")


def _recommendations(plan: pd.DataFrame) -> Iterator[str]:
    """Yield a line for each of the pairs that need the most seeds: how many seeds, and for which measure."""
    from analysis.stats.power import MOST_RECOMMENDED, pair_name, recommended

    rows = recommended(plan).sort_values("seeds", ascending=False, kind="stable")
    for row in rows.head(_MOST_ADVICE).to_dict("records"):
        pair = pair_name(row)
        if row["enough"]:
            yield f"{pair}: play {row['seeds']:.0f} seeds"
            yield f"  enough for: {', '.join(row['enough'])}"
        else:
            yield f"{pair}: no number of seeds up to {MOST_RECOMMENDED} is enough"
        if row["beyond"]:
            yield f"  more than {MOST_RECOMMENDED} seeds: {', '.join(row['beyond'])}"
        if row["without_n"]:
            yield f"  number of seeds unknown for {counted(row['without_n'], 'measure')}; the notes above say why"
    if len(rows) > _MOST_ADVICE:
        further = counted(len(rows) - _MOST_ADVICE, "further pair")
        yield f"not shown: {further} of conditions; each needs fewer seeds than these, or no number is enough"


def _tests(plan: pd.DataFrame) -> str:
    """Return the number of tests that are corrected together, such as `8 tests`; factors may have different numbers."""
    fewest, most = int(plan["family"].min()), int(plan["family"].max())
    return counted(most, "test") if fewest == most else f"{fewest} to {most} tests"


def _show_looks(plan: pd.DataFrame, looks: Sequence[int]) -> None:
    from analysis.stats.stopping import with_looks

    rows = [
        (*_first(row), *(_number(row[name], form) for name, form in _LOOKS.items()), str(row["note"]))
        for row in with_looks(plan, looks).to_dict("records")
    ]
    _print_rows(rows, _AT_LOOKS, left_out=("pairs", "sd"))
    _explain(f"power: chance that a look finds the difference at level .05, corrected for {_tests(plan)}.")
    _explain(f"seeds: mean number of seeds until a look finds the difference; if none does, {looks[-1]} seeds count.")
    _explain("cautious power, cautious seeds: computed with the upper 80 % bound of the pilot's sd.")
    say("Declare these looks with foundry preregister.")


def _print_rows(rows: Sequence[Sequence[str]], columns: Sequence[str], left_out: Sequence[str]) -> None:
    """Print a table; on a narrow terminal, a table per contrast, with the notes below and without some columns."""
    from foundry.display import WIDE, frame_table

    if console().width >= WIDE:
        console().print(frame_table(rows, columns))
        return
    shown_at = [at for at, name in enumerate(columns) if name not in (*left_out, "contrast", "note")]
    by_contrast: dict[str, list[Sequence[str]]] = defaultdict(list)
    for row in rows:
        by_contrast[row[1]].append(row)
    for contrast, group in by_contrast.items():
        print(f"\n{contrast}")
        planned = [[row[at] for at in shown_at] for row in group if set(row[len(_FIRST) : -1]) != {"-"}]
        if planned:
            console().print(frame_table(planned, [columns[at] for at in shown_at]))
        for note in dict.fromkeys(row[-1] for row in group if row[-1]):
            print(_wrapped(f"  {note}: {', '.join(row[0] for row in group if row[-1] == note)}"))
    print()


def _explain(line: str) -> None:
    say(_wrapped(line))


def _wrapped(line: str) -> str:
    """Return a line that breaks at spaces on a terminal, with the indentation of the line and four spaces."""
    from analysis.paper.ending import wrapped

    if not sys.stdout.isatty():
        return line
    indent = " " * (len(line) - len(line.lstrip()) + 4)
    return "\n".join(wrapped(line, console().width, further=indent))


def _row(row: Mapping[Hashable, object]) -> tuple[str, ...]:
    seeds = [_number(row[name], ".0f") for name in ("n_alone", "n_family", "n_cautious")]
    return (*_first(row), *seeds, str(row["note"]))


def _first(row: Mapping[Hashable, object]) -> tuple[str, ...]:
    from analysis.stats.power import pair_name

    numbers = [_number(row[name], ".3g") for name in ("sd", "difference")]
    return (str(row["measure"]), pair_name(row), str(row["n_pairs"]), *numbers)


def _number(value: object, form: str) -> str:
    return format(value, form) if isinstance(value, float) and not math.isnan(value) else "-"
