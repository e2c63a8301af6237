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
        "Likeness to the described path, if successful (SDTW)",
        better=HIGH,
        says="follows the described path {better|worse}",
    ),
    "legs": share(
        "Legs of the described path, walked in order (share)",
        better=HIGH,
        says="walks {more|fewer} legs of the described path",
    ),
}

HEADLINE = ("sdtw", "legs")

REACHED_M = 1.0
"""A leg counts as walked if the path comes at least this near to the end of the leg, seen from above, metres."""


def applies(run: CameraRun) -> bool:
    """Return whether the world describes a route."""
    return "grain" in run.world


def measure(run: CameraRun) -> dict[str, float]:
    """Return how well the agent followed the route that its instruction describes.

    `path_efficiency` measures arrival and directness; its shortest path is the described one. Its success,
    oracle_success, spl, soft_spl, ndtw and distance_to_goal (navigation error) are as in VLN-CE and Habitat.

    - sdtw: success x nDTW of `path_efficiency`; 0..1. NaN if either is NaN. Source: Ilharco et al. 2019.
    - legs: walked legs / described legs; 0..1. A leg is walked if the foot came within REACHED_M of its end after it
      had walked the earlier legs. NaN without decisions.

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
    """Return how many legs of a route were walked: the path came near the end of each of them, in order.

    Args:
        path: corners of the walked path, (n, 2).
        ends: ends of the legs, in order, (k, 2).
    """
    for walked, end in enumerate(ends):
        nearest = _nearest(path, end)
        near = np.flatnonzero(np.hypot(*(end - nearest).T) <= REACHED_M)
        if not near.size:
            return walked
        path = np.concatenate([nearest[near[:1]], path[near[0] + 1 :]])
    return len(ends)


def _nearest(path: FloatArray, point: FloatArray) -> FloatArray:
    """Return, for each straight piece of a path (n, 2), its nearest point to `point`; then the path's end."""
    ways = np.diff(path, axis=0, append=path[-1:])
    length = np.maximum((ways**2).sum(axis=1), 1e-12)
    along = np.clip(((point - path) * ways).sum(axis=1) / length, 0.0, 1.0)
    return np.asarray(path + along[:, None] * ways)
