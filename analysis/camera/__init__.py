"""Runs of 3D worlds: one agent that walks through a scene and sees images of it."""

from collections.abc import Sequence

import pandas as pd

from analysis.camera.camera_events import events
from analysis.camera.camera_records import read_records, schema
from analysis.camera.camera_run import CameraRun, command_kinds
from analysis.form import Decisions, Figures, FormAnalysis, Words
from analysis.labelling import Labelling

_UNLABELLED, _LABELLED = "recognition.n_unlabelled", "recognition.n_replies"


def _notes(runs: pd.DataFrame, _: Sequence[Labelling]) -> list[str]:
    missing, labelled = (int(runs[name].sum()) if name in runs else 0 for name in (_UNLABELLED, _LABELLED))
    if not missing:
        return []
    return [
        f"{missing} of {missing + labelled} replies have no label because the rule covers only English and "
        "Japanese; measures of recognition leave these replies out"
    ]


def _methods(_: Sequence[Labelling]) -> list[str]:
    return ["Distances in 3D are lengths of shortest paths on the walkable floor, seen from above."]


WORDS = Words(
    unread="count as staying, which changes idle rate, stability, clustering and exploration",
    notes=_notes,
    methods=_methods,
)


def _decided(run: CameraRun) -> dict[str, Decisions]:
    return {"move": Decisions(command_kinds(run)[:, None], run.readable[:, None])}


def _figures(seed: int) -> Figures:
    from analysis.camera.camera_figures import CameraFigures  # drawing code is not needed to load a sweep

    return CameraFigures(seed)


ANALYSIS = FormAnalysis(
    name="camera",
    run=CameraRun,
    read=read_records,
    schema=schema,
    decided=_decided,
    figures=_figures,
    words=WORDS,
    events=events,
)
