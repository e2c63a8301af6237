"""Cost: what a run took in calls, tokens and time."""

from __future__ import annotations

from analysis.any.signatures.cost import HEADLINE, MEASURES, NAME, READABLE_TOO, cost_measures
from analysis.grid.run import GridRun

__all__ = ["HEADLINE", "MEASURES", "NAME", "READABLE_TOO", "measure"]


def measure(run: GridRun) -> dict[str, float]:
    """Return the cost of a run of a 2D world: the same measures; a decision is an agent's step, with all its calls."""
    return cost_measures(run.cost, run.decisions)
