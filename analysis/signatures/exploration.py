"""Exploration: how much of their world agents come through."""

from __future__ import annotations

import math

import numpy as np

from analysis.camera_run import CameraRun
from analysis.described import Measure, share
from analysis.formulas import entropy, mean, ratio
from analysis.run import GridRun, IntArray

NAME = "exploration"

MEASURES = {
    "coverage": share("Visited cells (share of those in reach, mean of agents)"),
    "group_coverage": share("Cells visited by anyone (share of the grid)"),
    "unique_ratio": share("New cells per state"),
    "visit_entropy": share("Entropy of visits (of its maximum)"),
    "gyration": Measure("Radius of gyration (cells)", low=0),
    "revisit_rate": share("Revisits (share of states)"),
    "path_length": Measure("Way covered (m)", low=0),
    "gyration_m": Measure("Radius of gyration (m)", low=0),
}

HEADLINE = ("coverage", "unique_ratio", "group_coverage", "gyration", "path_length")


def measure(run: GridRun) -> dict[str, float]:
    """Return the exploration of a run, over states 0..T, mean over agents.

    - coverage: different cells an agent was in / cells of the grid, all reachable; above 0..1. Bounded by
      T + 1, so never compare runs of different T by it.
    - group_coverage: cells that any agent was in / cells of the grid.
    - unique_ratio: different cells / (T + 1); above 0..1.
    - visit_entropy: entropy of an agent's visits over cells / log2 of the cells of the grid; 0..1.
    - gyration: root mean square distance of an agent's states from their mean, cells; 0 up.
    - revisit_rate: 1 - unique_ratio: share of states in a cell visited before; 0..1.

    An agent that never moves has one cell, entropy 0 and revisit rate T / (T + 1).
    Denominators: n_agents, n_states (T + 1), n_cells.
    """
    paths = [np.column_stack([run.x[:, agent], run.y[:, agent]]) for agent in range(run.agents)]
    each = [path_measures(path, run.world.cells) for path in paths]
    group = len(np.unique(np.concatenate(paths), axis=0))
    return {
        **{name: mean(one[name] for one in each) for name in each[0]},
        "group_coverage": group / run.world.cells,
        "n_agents": float(run.agents),
        "n_states": float(run.steps + 1),
        "n_cells": float(run.world.cells),
    }


def measure_camera(run: CameraRun) -> dict[str, float]:
    """Return the exploration of a run of a 3D world.

    - coverage: cells of the walkable grid that the body covered, start included / those that can be reached from the
      start; 0..1. NaN without decisions, or when no cell can be reached. Never compare runs with different limits of
      decisions by it.
    - path_length: the way covered, metres; 0 up.
    - gyration_m: root mean square distance of the places of states 0..T from their mean, metres; 0 up.

    Denominators: n_states (T + 1), n_cells, n_visited.
    """
    visited = int(run.visited[-1:].sum())
    return {
        "coverage": ratio(visited, run.episode.walkable_cells) if run.decisions else math.nan,
        "path_length": run.path_length,
        "gyration_m": math.sqrt(float(run.foot.var(axis=0).sum())),
        "n_states": float(run.decisions + 1),
        "n_cells": float(run.episode.walkable_cells),
        "n_visited": float(visited),
    }


def path_measures(path: IntArray, cells: int) -> dict[str, float]:
    """Return the exploration of one agent.

    Args:
        path: its cells in order, start included, (T + 1, 2).
        cells: number of reachable cells.
    """
    visits = np.unique(path, axis=0, return_counts=True)[1]
    unique_ratio = len(visits) / len(path)
    return {
        "coverage": len(visits) / cells,
        "unique_ratio": unique_ratio,
        "visit_entropy": entropy(visits) / math.log2(cells) if cells > 1 else math.nan,
        "gyration": math.sqrt(float(path.var(axis=0).sum())),
        "revisit_rate": 1 - unique_ratio,
    }
