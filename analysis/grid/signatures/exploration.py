"""Exploration: how much of the world agents visit."""

import math

import numpy as np

from analysis.formulas import entropy, mean
from analysis.grid.grid_run import GridRun
from analysis.grid.walker import expected_cells
from analysis.measure import Measure, Null, share

NAME = "exploration"

MEASURES = {
    "coverage": share("Visited cells (share of reachable cells, mean of agents)", says="visits {more|fewer} cells"),
    "group_coverage": share("Cells visited by anyone (share of the grid)"),
    "unique_ratio": share("Different cells (share of states)"),
    "walker_ratio": Measure(
        "Different cells, relative to a random walker from the same start",
        low=0,
        null=Null(1, "moves in all directions alike, never stays", by_random=False),
    ),
    "visit_entropy": share("Entropy of visits (of its maximum)"),
    "gyration": Measure("Radius of gyration (cells)", low=0),
    "revisit_rate": share("Revisits (share of states)"),
}

HEADLINE = ("coverage", "walker_ratio", "group_coverage", "gyration")


def measure(run: GridRun) -> dict[str, float]:
    """Return the exploration of a run; measures of single agents are means over agents.

    An agent's states are its start and the states after its counted decisions; T is the number of these decisions.

    - coverage: different cells of an agent / cells of the grid without a wall; above 0..1. An agent visits at most T +
      1 cells, so compare only runs with equal T.
    - group_coverage: cells visited by any agent / cells of the grid.
    - unique_ratio: different cells / (T + 1); above 0..1.
    - walker_ratio: different cells / their expected number for a random walker; above 0. The walker makes T moves from
      the same start, and every legal move is equally likely. The expectation is exact: the sum over all cells of the
      probability of a visit, edges included. NaN in a world with walls. Source of the quantity: Dvoretzky and Erdos
      1951.
    - visit_entropy: entropy (bits) of the distribution of an agent's states over the cells / log2 of the number of
      cells of the grid; 0..1. NaN on a grid of one cell.
    - gyration: root mean square distance between an agent's states and their mean position, cells; from 0.
    - revisit_rate: share of states in a cell that the agent had visited before, 1 - unique_ratio; 0..1.

    An agent that never moves has one cell, entropy 0 and revisit rate T / (T + 1).
    Denominators: n_agents, n_states (T + 1, mean over agents), n_cells.
    """
    counted = np.vstack([np.zeros(run.agents, dtype=np.bool_), run.counted])
    start, half_size = (run.first, np.arange(run.agents)), run.world.half_size
    counted[start] = True
    cell = (run.x + half_size) * run.world.width + run.y + half_size
    cells, states = run.world.cells, counted.sum(axis=0)
    visits = [np.unique_counts(own[flags]).counts for own, flags in zip(cell.T, counted.T, strict=True)]
    unique = np.array([len(counts) for counts in visits])
    # The closed form holds for the open square.
    expected = np.nan if run.world.walls else expected_cells(run.x[start], run.y[start], states - 1, half_size)
    return {
        "coverage": mean(unique / cells),
        "group_coverage": len(np.unique(cell[counted])) / cells,
        "unique_ratio": mean(unique / states),
        "walker_ratio": mean(unique / expected),
        "visit_entropy": mean(entropy(counts) / math.log2(cells) for counts in visits) if cells > 1 else math.nan,
        "gyration": mean(np.sqrt(np.var(run.x, axis=0, where=counted) + np.var(run.y, axis=0, where=counted))),
        "revisit_rate": mean(1 - unique / states),
        "n_agents": float(run.agents),
        "n_states": mean(states),
        "n_cells": float(cells),
    }
