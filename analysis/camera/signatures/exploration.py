"""Exploration: how much of the world agents visit."""

import math

import numpy as np

from analysis.camera.camera_run import CameraRun
from analysis.formulas import ratio
from analysis.measure import Measure, share

NAME = "exploration"

MEASURES = {
    "coverage": share("Visited cells (share of reachable cells, mean of agents)", says="visits {more|fewer} cells"),
    "path_length": Measure("Length of the path (m)", low=0, says="walks {further|less far}"),
    "gyration_m": Measure("Radius of gyration (m)", low=0),
}

HEADLINE = ("coverage", "path_length")


def measure(run: CameraRun) -> dict[str, float]:
    """Return the exploration of a run of a 3D world.

    - coverage: cells of the walkable grid that the body covered, start included / cells reachable from the start; 0..1.
      NaN without decisions, or if no cell is reachable. Compare coverage only between runs with the same limit of
      decisions.
    - path_length: covered distance, metres; 0 up.
    - gyration_m: root mean square distance from the mean place, metres; 0 up. The mean is over the start and the states
      after counted decisions.

    Denominators: n_states (of gyration_m), n_cells, n_visited.
    """
    counted = np.concatenate([[True], run.counted])
    visited = int(run.visited[-1:].sum())
    return {
        "coverage": ratio(visited, run.episode.walkable_cells) if run.decisions else math.nan,
        "path_length": run.path_length,
        "gyration_m": math.sqrt(float(run.foot[counted].var(axis=0).sum())),
        "n_states": float(counted.sum()),
        "n_cells": float(run.episode.walkable_cells),
        "n_visited": float(visited),
    }
