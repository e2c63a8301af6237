"""Exploration: how much of the grid agents see of it by walking."""

from __future__ import annotations

import math

import numpy as np

from analysis.described import Measure, share
from analysis.formulas import entropy, mean
from analysis.run import GridRun, IntArray

NAME = "exploration"

MEASURES = {
    "coverage": share("Visited cells (share of the grid, mean of agents)"),
    "group_coverage": share("Cells visited by anyone (share of the grid)"),
    "unique_ratio": share("New cells per state"),
    "visit_entropy": share("Entropy of visits (of its maximum)"),
    "gyration": Measure("Radius of gyration (cells)", low=0),
    "revisit_rate": share("Revisits (share of states)"),
}

HEADLINE = ("unique_ratio", "group_coverage", "gyration")


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
