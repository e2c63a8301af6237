"""Reads every complete run once, and collects the content of plots and tables of single runs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from analysis.figures.members import Member
from analysis.figures.shown import ShownGroup
from analysis.form import Figures, RunTable
from analysis.labelling import Labelling
from analysis.load import measurable
from analysis.plots import Picture


@dataclass(frozen=True)
class Examples:
    """Plots and tables of single runs.

    Attributes:
        doubts: by the id of a run, step and agent of its first unreadable decision.
    """

    pictures: tuple[Picture, ...] = ()
    tables: tuple[RunTable, ...] = ()
    doubts: Mapping[str, tuple[int, int]] = field(default_factory=dict)


def examples(members: Sequence[Member], shown: Sequence[ShownGroup], labellings: Mapping[str, Labelling]) -> Examples:
    """Read the complete runs.

    Raises:
        RecordError: a recorded file is damaged.
    """
    seed = min(member.seed for member in members)
    figures: dict[str, Figures] = {}
    doubts: dict[str, tuple[int, int]] = {}
    for member in members:
        whole = measurable(member.folder, member.summary)
        if whole is not None:
            run = whole.form.labelled(whole.run, labellings[member.folder.id])
            if not run.readable.all():
                doubts[run.id] = first_doubt(run)
            if whole.form.figures is not None:
                own = figures.setdefault(whole.form.name, whole.form.figures(seed))
                own.add(member.shown, run, member.seed)
    return Examples(
        pictures=tuple(picture for figure in figures.values() for picture in figure.pictures(shown)),
        tables=tuple(table for figure in figures.values() for table in figure.tables(shown)),
        doubts=doubts,
    )


def first_doubt(run: Any) -> tuple[int, int]:
    """Return step and agent of the first unreadable decision of a run."""
    step, *agent = np.argwhere(~run.readable)[0].tolist()
    return step + 1, agent[0] if agent else 0
