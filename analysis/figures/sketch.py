"""Draws several runs in one figure for a paper: their state after some steps, or the whole paths of agents."""

from collections.abc import Mapping, Sequence
from functools import partial

from analysis.figures.shown import ShownGroup
from analysis.form import form_of
from analysis.load import read_records, read_run
from analysis.plots import Picture, draw
from foundry.errors import InputError
from foundry.naming import in_room
from foundry.storing.store import RunFolder


def sketch(runs: Mapping[str, RunFolder], steps: Sequence[int] | None) -> str:
    """Return complete runs as one SVG.

    Args:
        runs: the runs, all of one form, by their names in the figure.
        steps: steps after which runs are drawn, ascending; None for whole paths.

    Raises:
        InputError: runs of this form have no figure.
        RecordError: the records are damaged.
    """
    names = list(dict.fromkeys(run.declared.form for run in runs.values()))
    form = form_of(names[0]).name
    drawn = in_room(f"analysis.{form}.{form}_sketch", "sketch")
    if len(names) > 1 or drawn is None:
        raise InputError(
            f"--svg draws runs of one form (grid, camera or rounds), but these have the form {' and '.join(names)}."
        )
    shown = [
        (ShownGroup((name,), run.model_place, baseline=False), read_run(run, read_records(run, run.summary())))
        for name, run in runs.items()
    ]
    columns = 1 if len(shown) * len(steps or (0,)) == 1 else 2
    return draw(Picture("replay", "", "", partial(drawn, shown, steps)), "svg", columns=columns).svg
