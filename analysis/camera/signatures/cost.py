"""Cost: what a run took in calls, tokens and time."""

from __future__ import annotations

from analysis.any.signatures.cost import HEADLINE, MEASURES, NAME, READABLE_TOO, cost_measures
from analysis.camera.run import CameraRun

__all__ = ["HEADLINE", "MEASURES", "NAME", "READABLE_TOO", "measure"]


def measure(run: CameraRun) -> dict[str, float]:
    """Return the cost of a run of a 3D world: the same measures; one call is one decision."""
    return cost_measures(run.cost, run.decisions)
