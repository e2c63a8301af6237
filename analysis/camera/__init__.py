"""Runs of 3D worlds: one agent that walks through a scene and sees pictures of it."""

from __future__ import annotations

from analysis.camera.columns import schema
from analysis.camera.command_kinds import command_kinds
from analysis.camera.records import read_records
from analysis.camera.run import CameraRun
from analysis.camera.words import WORDS
from analysis.form import Decisions, Figures, FormAnalysis


def _decided(run: CameraRun) -> dict[str, Decisions]:
    return {"move": Decisions(command_kinds(run)[:, None], run.readable[:, None])}


def _figures(seed: int) -> Figures:
    from analysis.camera.figures import CameraFigures  # what is drawn is not needed to load a sweep

    return CameraFigures(seed)


ANALYSIS = FormAnalysis(
    name="camera",
    run=CameraRun,
    read=read_records,
    schema=schema,
    decided=_decided,
    figures=_figures,
    words=WORDS,
)
