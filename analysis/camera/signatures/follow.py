"""Following: how much of a described route an agent of a 3D world walked, leg by leg."""

import math

import numpy as np

from analysis.arrays import FloatArray
from analysis.camera.camera_run import CameraRun
from analysis.camera.signatures import path_efficiency
from analysis.measure import HIGH, share

NAME = "follow"

MEASURES = {
    "sdtw": share(
        "Likeness to the told way, where it succeeded (SDTW)", better=HIGH, says="follows the told way {better|worse}"
    ),
    "legs": share(
        "Legs of the told way, walked in their order (share)",
        better=HIGH,
        says="walks {more|fewer} legs of the told way",
    ),
}

HEADLINE = ("sdtw", "legs")

REACHED_M = 1.0
"""How near to the end of a leg, seen from above, it counts as walked."""


def applies(run: CameraRun) -> bool:
    """Return whether the world tells a way."""
    return "grain" in run.world


def measure(run: CameraRun) -> dict[str, float]:
    """Return how a told way was followed.

    Whether and how directly the agent arrived is `path_efficiency`, whose shortest way is the one that is told:
    success, oracle_success, spl, soft_spl, ndtw and distance_to_goal (navigation error) as in VLN-CE and Habitat.

    - sdtw: success x nDTW of `path_efficiency`; 0..1. NaN as either. Source: Ilharco et al. 2019.
    - legs: legs walked / legs told; a leg is walked when the foot came up to REACHED_M from its end after it did so for
      all legs before; 0..1. NaN without decisions.

    Denominators: n_decisions, n_legs.
    """
    arrived = path_efficiency.measure(run)
    ends = np.array([leg["end"][:2] for leg in run.facts.get("legs", ())], dtype=np.float64).reshape(-1, 2)
    return {
        "sdtw": arrived["success"] * arrived["ndtw"],
        "legs": walked(run.foot[:, :2], ends) / len(ends) if run.counted.any() and len(ends) else math.nan,
        "n_decisions": float(run.counted.sum()),
        "n_legs": float(len(ends)),
    }


def walked(path: FloatArray, ends: FloatArray) -> int:
    """Return how many ends (k, 2) a path (n, 2) of straight pieces came near to in their order."""
    for found, end in enumerate(ends):
        nearest = _nearest(path, end)
        near = np.flatnonzero(np.hypot(*(end - nearest).T) <= REACHED_M)
        if not near.size:
            return found
        path = np.concatenate([nearest[near[:1]], path[near[0] + 1 :]])
    return len(ends)


def _nearest(path: FloatArray, point: FloatArray) -> FloatArray:
    """Return the place of each straight piece of a path (n, 2) that is nearest to a point (2,); its end is a piece."""
    ways = np.diff(path, axis=0, append=path[-1:])
    length = np.maximum((ways**2).sum(axis=1), 1e-12)
    along = np.clip(((point - path) * ways).sum(axis=1) / length, 0.0, 1.0)
    return np.asarray(path + along[:, None] * ways)
