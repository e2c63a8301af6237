"""Turning: how much an agent of a 3D world turns its body, and to which side."""

import numpy as np

from analysis.camera.camera_run import CameraRun
from analysis.formulas import mean, ratio
from analysis.measure import Measure, Null, share

NAME = "turning"

MEASURES = {
    "rate": Measure("Turn per decision (degrees)", low=0, says="turns {more|less}"),
    "share": share("Decisions with a turn (share)"),
    "angle": Measure("Turn per turning decision (degrees)", low=0),
    "left_bias": Measure("Left against right turns (-1 right, 1 left)", -1, 1, Null(0, "turns to either side alike")),
}

HEADLINE = ("rate", "share", "left_bias")


def measure(run: CameraRun) -> dict[str, float]:
    """Return how much the agent asks to turn its body in a run; nothing ever blocks a turn.

    - rate: mean |turn| over all decisions, degrees; 0 up.
    - share: decisions with a turn / decisions; 0..1.
    - angle: mean |turn| over the decisions with a turn, degrees. NaN without turns.
    - left_bias: (left - right) / (left + right), numbers of turns; -1..1. NaN without turns.

    All are NaN without decisions. Denominators: n_decisions, n_turns.
    """
    asked = run.turn[run.counted]
    turns = asked[asked != 0]
    return {
        "rate": mean(np.abs(asked)),
        "share": ratio(len(turns), len(asked)),
        "angle": mean(np.abs(turns)),
        "left_bias": mean(np.sign(turns)),
        "n_decisions": float(len(asked)),
        "n_turns": float(len(turns)),
    }
