"""What commands show of an analysis."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from foundry.commands.application import console


def analyze_and_show(folders: Sequence[Path], *, brief: bool = False, **options: Any) -> None:
    """Analyse sweeps with these options of `analysis.analyze` and print the short tables, or the shortest."""
    from analysis import analyze as analyze_folders
    from foundry.display import frame_table

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
