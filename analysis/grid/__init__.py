"""Runs of 2D worlds: places, fires, agents that move by cells and talk to agents nearby."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from analysis.form import Decisions, Figures, FormAnalysis, Twin, Words
from analysis.grid.grid_crop import crop
from analysis.grid.grid_events import events
from analysis.grid.grid_records import fixtures, labelled, read_records, schema
from analysis.grid.grid_run import GridRun
from analysis.labelling import Labelling
from analysis.prose import joined

_SIGNATURE = "warning"
_UNLABELLED, _MESSAGES = f"{_SIGNATURE}.n_unlabelled", f"{_SIGNATURE}.n_messages"


def _notes(runs: pd.DataFrame, labellings: Sequence[Labelling]) -> list[str]:
    """Return notes on the labels of messages as warnings: the labeller, its agreement with people, missing labels."""
    if _UNLABELLED not in runs:
        return []
    missing, said = (int(runs[name].sum()) for name in (_UNLABELLED, _MESSAGES))
    why = " or ".join(dict.fromkeys(labelling.unlabelled for labelling in labellings))
    notes = (
        [f"{missing} of {said} messages have no label because {why}; the measures that need these labels are missing"]
        if missing
        else []
    )
    return [*dict.fromkeys(labelling.brief() for labelling in labellings), *notes]


def _methods(labellings: Sequence[Labelling]) -> list[str]:
    labellers = joined(dict.fromkeys(labelling.labeller for labelling in labellings))
    return [f"{labellers} decided which messages are warnings."]


def _limits(labellings: Sequence[Labelling]) -> list[str]:
    limits = dict.fromkeys(labelling.note() for labelling in labellings)
    notes = " ".join(f"{note[0].upper()}{note[1:]}." for note in limits)
    return [f"In these runs, no person labelled which messages are warnings. {notes}"]


def _doubts(labellings: Sequence[Labelling]) -> dict[str, str]:
    doubts = list(dict.fromkeys(filter(None, (labelling.doubt() for labelling in labellings))))
    return {_SIGNATURE: joined(doubts)} if doubts else {}


WORDS = Words(
    unread="count as staying, which changes idle rate, stability, clustering and exploration",
    notes=_notes,
    methods=_methods,
    limits=_limits,
    doubts=_doubts,
)


SILENT, SPOKEN = 0, 1
"""The choices of a message."""


def _decided(run: GridRun) -> dict[str, Decisions]:
    spoken = np.where(run.spoke, SPOKEN, SILENT)
    return {"message": Decisions(spoken, run.message_readable), "action": Decisions(run.choice, run.readable)}


def _figures(seed: int) -> Figures:
    from analysis.grid.grid_pictures import GridFigures  # drawing code is not needed to load a sweep

    return GridFigures(seed)


ANALYSIS = FormAnalysis(
    name="grid",
    run=GridRun,
    read=read_records,
    schema=schema,
    fixtures=fixtures,
    labelled=labelled,
    decided=_decided,
    crop=crop,
    figures=_figures,
    words=WORDS,
    events=events,
    twin=Twin(
        "tell_fires",
        told=True,
        measures={
            "hazard.away_beyond_blind": "hazard.away_beyond_untold",
            "hazard.distance_beyond_blind": "hazard.distance_beyond_untold",
        },
    ),
)
