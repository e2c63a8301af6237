"""Runs of 2D worlds: places, fires, agents that move by cells and talk to who is near."""

from __future__ import annotations

import numpy as np

from analysis.form import Decisions, Figures, FormAnalysis, Twin
from analysis.grid.columns import schema
from analysis.grid.records import fixtures, labelled, read_records
from analysis.grid.run import GridRun
from analysis.grid.words import WORDS

SILENT, SPOKEN = 0, 1
"""The choices of a message."""


def _decided(run: GridRun) -> dict[str, Decisions]:
    spoken = np.where(run.spoke, SPOKEN, SILENT)
    return {"message": Decisions(spoken, run.message_readable), "action": Decisions(run.choice, run.readable)}


def _figures(seed: int) -> Figures:
    from analysis.grid.pictures import GridFigures  # what is drawn is not needed to load a sweep

    return GridFigures(seed)


ANALYSIS = FormAnalysis(
    name="grid",
    run=GridRun,
    read=read_records,
    schema=schema,
    fixtures=fixtures,
    labelled=labelled,
    decided=_decided,
    figures=_figures,
    words=WORDS,
    twin=Twin(
        "tell_fires",
        told=True,
        measures={
            "hazard.away_beyond_blind": "hazard.away_beyond_untold",
            "hazard.distance_beyond_blind": "hazard.distance_beyond_untold",
        },
    ),
)
