"""What commands show of an analysis."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from foundry.commands.application import console
from foundry.errors import InputError


def analyze_and_show(folders: Sequence[Path], *, brief: bool = False, **options: Any) -> None:
    """Analyse sweeps with these options of `analysis.analyze` and print the short tables, or the shortest."""
    from analysis import analyze as analyze_folders
    from foundry.display import frame_table

    if _show_probe(folders, options):
        return
    with _watched() as watch:
        analysis = analyze_folders(folders, watch=watch, **options)
    screen = console()
    for table in analysis.headlines(screen.width, brief=brief):
        screen.print(frame_table(table.rows, table.columns))
        if table.caption:
            screen.print(f"{table.caption}\n", style="dim", highlight=False, markup=False)
    for note in analysis.notes:
        print(note)
    print(f"tables and plots in {analysis.path}")


def _show_probe(folders: Sequence[Path], options: Mapping[str, Any]) -> bool:
    """Analyse a probe and print its short tables; returns whether it is one.

    Raises:
        InputError: there are other sweeps beside it, or something is asked that its tables do not have.
    """
    from analysis.probes import analyze_probe, is_probe
    from foundry.display import frame_table
    from foundry.storing.store import SweepFolder

    opened = [SweepFolder.open(folder) for folder in folders]
    if not any(map(is_probe, opened)):
        return False
    if len(opened) > 1:
        raise InputError(f"'{folders[0]}' and others hold a probe: analyse a probe by itself, foundry analyze FOLDER.")
    if any(options.values()):
        raise InputError(
            f"'{folders[0]}' is a probe, whose tables know no families, margins and labels: leave them out."
        )
    analysis, screen = analyze_probe(opened[0]), console()
    for table in analysis.tables:
        screen.print(frame_table(table.rows, table.columns))
        screen.print(f"{table.caption}\n", style="dim", highlight=False, markup=False)
    for note in analysis.notes:
        print(note)
    print(f"tables in {analysis.path}")
    return True


@contextlib.contextmanager
def _watched() -> Iterator[Callable[[int, int], None] | None]:
    """Show on a terminal how many runs are measured; elsewhere nothing."""
    screen = console()
    if not screen.is_terminal:
        yield None
        return
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    with Progress("measuring", BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(), transient=True) as bars:
        task = bars.add_task("measuring")
        yield lambda done, total: bars.update(task, completed=done, total=total)
