"""Gaze: how much an agent of a 3D world looks up and down."""

import numpy as np

from analysis.camera.camera_run import CameraRun
from analysis.formulas import mean, ratio
from analysis.measure import Measure, Null, share

NAME = "gaze"

MEASURES = {
    "rate": Measure("Turn of the gaze per decision (degrees)", low=0, says="turns its gaze {more|less}"),
    "share": share("Decisions that turn the gaze (share)"),
    "mean_pitch": Measure("Mean pitch of the images (degrees)", -90, 90, Null(0, "looks up and down alike")),
    "mean_tilt": Measure("Mean tilt of the images, up or down (degrees)", low=0, high=90),
}

HEADLINE = ("rate", "share", "mean_pitch")


def measure(run: CameraRun) -> dict[str, float]:
    """Return the turns of the gaze in a run.

    - rate: mean |executed change of pitch| over all decisions, degrees; 0 up. The world limits the pitch.
    - share: decisions that request a turn of the gaze / decisions; 0..1.
    - mean_pitch: mean pitch of the images, degrees, up positive.
    - mean_tilt: mean |pitch| of these images, degrees.

    All are NaN without decisions. Denominators: n_decisions, n_gazes.
    """
    gazes, seen = int((run.gaze[run.counted] != 0).sum()), run.pitch[:-1][run.counted]
    return {
        "rate": mean(np.abs(np.diff(run.pitch)[run.counted])),
        "share": ratio(gazes, len(seen)),
        "mean_pitch": mean(seen),
        "mean_tilt": mean(np.abs(seen)),
        "n_decisions": float(len(seen)),
        "n_gazes": float(gazes),
    }
