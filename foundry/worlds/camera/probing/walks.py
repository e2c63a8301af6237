"""The pictures of a walk: places along a way, a bounded number of them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from foundry.records import Pose
from foundry.worlds.camera.body.pose import make_pose
from foundry.worlds.camera.loading.scene import FloatArray


def along(start: Pose, points: FloatArray, facing: float, number: int) -> list[Pose]:
    """Return the poses of pictures on a way.

    The first is the start with its own heading; the others are evenly spaced along the way, looking where it goes; the
    last is its end, turned to what it leads to.

    Args:
        start: the first pose.
        points: the way, (k, 3) metres.
        facing: the last heading, degrees.
        number: how many pictures.
    """
    lengths = np.hypot(*np.diff(points[:, :2], axis=0).T)
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    places = np.linspace(0.0, ends[-1], number - 1)
    found = [start]
    for place in places[:-1]:
        piece = min(int(np.searchsorted(ends, place, side="right")) - 1, len(lengths) - 1)
        way = points[piece + 1] - points[piece]
        foot = points[piece] + way * ((place - ends[piece]) / max(lengths[piece], 1e-9))
        found.append(make_pose(foot, math.degrees(math.atan2(way[1], way[0])), 0.0))
    return [*found, make_pose(points[-1], facing, 0.0)]


def spread(poses: Sequence[Pose], number: int) -> list[int]:
    """Return the numbers of the poses that stand for a longer walk, evenly spread, the first and the last included."""
    return sorted({round(place) for place in np.linspace(0, len(poses) - 1, min(number, len(poses))).tolist()})
