"""Exploration: how much of their world agents visit."""

import math

import numpy as np

from analysis.camera.camera_run import CameraRun
from analysis.formulas import ratio
from analysis.measure import Measure, share

NAME = "exploration"

MEASURES = {
    "coverage": share("Visited cells (share of those in reach, mean of agents)", says="visits {more|fewer} cells"),
    "path_length": Measure("Way covered (m)", low=0, says="walks {further|less far}"),
    "gyration_m": Measure("Radius of gyration (m)", low=0),
}

HEADLINE = ("coverage", "path_length")


def measure(run: CameraRun) -> dict[str, float]:
    """Return the exploration of a run of a 3D world.

    - coverage: cells of the walkable grid that the body covered, start included / those that can be reached from the
      start; 0..1. NaN without decisions, or when no cell can be reached. Never compare runs with different limits of
      decisions by it.
    - path_length: the way covered, metres; 0 up.
    - gyration_m: root mean square distance of the places of the start and of the states that counted decisions led to
      from their mean, metres; 0 up.

    Denominators: n_states (of gyration_m), n_cells, n_visited.
    """
    kept = np.concatenate([[True], run.counted])
    visited = int(run.visited[-1:].sum())
    return {
        "coverage": ratio(visited, run.episode.walkable_cells) if run.decisions else math.nan,
        "path_length": run.path_length,
        "gyration_m": math.sqrt(float(run.foot[kept].var(axis=0).sum())),
        "n_states": float(kept.sum()),
        "n_cells": float(run.episode.walkable_cells),
        "n_visited": float(visited),
    }
