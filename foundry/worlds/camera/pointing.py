"""Where the target of a 3D run is in a picture, and in which direction it is where it is in none."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse.csgraph import connected_components

from foundry.records import Pose
from foundry.worlds.camera.body.navigation import SightLines, TargetSurfaces
from foundry.worlds.camera.body.surfaces import BoolArray, Surfaces
from foundry.worlds.camera.eye.rendering import angles, direction, in_picture, offsets_from
from foundry.worlds.camera.loading.scene import FloatArray, Scene
from foundry.worlds.camera.surroundings import foot_of, turn_between

NEAR_M = 0.02
"""What is nearer to the eye is in no picture."""

_FOLLOWING = (1, 2, 0)
"""Which corner of a triangle follows each of its corners."""


@dataclass(frozen=True, eq=False)
class Pointed:
    """Where a target is, as seen from a pose; places are shares of the picture's width and height, from its upper left.

    Attributes:
        boxes: (n, 2, 2) upper left and lower right of what of it lies within the picture, hidden or not; things of it
            that are apart have a box each, and those of which a point is seen leave out the others.
        spot: (2,) a point of it that is seen, or None where none of its points is.
        centred: whether its middle lies within the picture.
        turn: from the heading to its middle, degrees, left positive, -180..180.
        tilt: from the gaze to its middle, degrees, up positive.
    """

    boxes: FloatArray
    spot: FloatArray | None
    centred: bool
    turn: float
    tilt: float


class Pointer:
    """Points at a target from wherever somebody stands.

    Args:
        scene: where.
        prims: paths of the target's prims; everything below them belongs to it.
        frame: width and height of the pictures, pixels.
        fov_deg: their vertical angle of view.
        eye_height: of the eye above the foot, metres.

    Attributes:
        middle: (3,) of the target's surfaces, metres.
        boxes: (n, 2, 3) lowest and highest corner of each of its things that are apart, metres.
    """

    def __init__(
        self, scene: Scene, prims: tuple[str, ...], *, frame: tuple[int, int], fov_deg: float, eye_height: float
    ) -> None:
        surfaces = Surfaces(scene)
        self._target = TargetSurfaces(surfaces, prims)
        self._parts = [surfaces.corners[surfaces.mesh == number] for number in self._target.meshes]
        self._sight = SightLines(scene, surfaces)
        self._frame, self._fov_deg, self._eye_height = frame, fov_deg, eye_height
        self.middle: FloatArray = self._target.points.mean(axis=0)
        corners = [part.reshape(-1, 3) for part in self._parts if len(part)]
        self.boxes: FloatArray = joined(np.array([[one.min(axis=0), one.max(axis=0)] for one in corners]))

    def seen_from(self, pose: Pose) -> Pointed:
        """Return where the target is, as seen from a pose."""
        eye = foot_of(pose) + (0.0, 0.0, self._eye_height)
        axes = eye, direction(pose.yaw, pose.pitch), direction(pose.yaw, pose.pitch + 90)
        seen = self._shares(offsets_from(*axes, self._sight.points_seen(eye, self._target)))
        seen = seen[_within(seen)]
        boxes = [box for part in self._parts if (box := self._box(offsets_from(*axes, part))) is not None]
        yaw, pitch = angles(self.middle - eye)
        held = _holding(joined(np.array(boxes).reshape(-1, 2, 2)), seen)
        return Pointed(
            boxes=held,
            spot=_midmost(seen, held),
            centred=bool(_within(self._shares(offsets_from(*axes, self.middle[None]))).any()),
            turn=turn_between(pose.yaw, yaw),
            tilt=pitch - pose.pitch,
        )

    def _shares(self, offsets: FloatArray) -> FloatArray:
        """Return where (n, 3) offsets are in the picture, (k, 2); those behind the eye are left out."""
        return in_picture(offsets[offsets[:, 2] >= NEAR_M], self._frame, self._fov_deg) / self._frame

    def _box(self, corners: FloatArray) -> FloatArray | None:
        """Return the (2, 2) box around what of (n, 3, 3) triangles, as offsets, lies within the picture, or None."""
        following = corners[:, _FOLLOWING]
        crossing = (corners[..., 2] < NEAR_M) != (following[..., 2] < NEAR_M)
        start, end = corners[crossing], following[crossing]
        part = (NEAR_M - start[:, 2:]) / (end[:, 2:] - start[:, 2:])
        cut = np.append(start[:, :2] + part * (end - start)[:, :2], np.full((len(start), 1), NEAR_M), axis=1)
        places = self._shares(np.concatenate([corners.reshape(-1, 3), cut]))
        if not len(places):
            return None
        box = np.clip([places.min(axis=0), places.max(axis=0)], 0.0, 1.0)
        return box if (box[0] < box[1]).all() else None


def joined(boxes: FloatArray) -> FloatArray:
    """Return (n, 2, k) boxes, lowest and highest corner each, with those that overlap or touch as one."""
    if not len(boxes):
        return boxes
    low, high = boxes[:, 0], boxes[:, 1]
    touching = np.asarray((low[:, None] <= high).all(axis=2) & (low <= high[:, None]).all(axis=2))
    count, group = connected_components(touching, directed=False)
    groups = [group == number for number in range(count)]
    return np.array([[low[one].min(axis=0), high[one].max(axis=0)] for one in groups])


def _within(places: FloatArray) -> BoolArray:
    return np.asarray(((places >= 0) & (places <= 1)).all(axis=1))


def _inside(boxes: FloatArray, places: FloatArray) -> BoolArray:
    """Return which of (n, 2, 2) boxes holds which of (k, 2) places, (n, k)."""
    return np.asarray(((boxes[:, :1] <= places) & (places <= boxes[:, 1:])).all(axis=2))


def _holding(boxes: FloatArray, places: FloatArray) -> FloatArray:
    """Return the boxes that hold one of (k, 2) places, or all of them where none does."""
    holding = _inside(boxes, places).any(axis=1)
    return boxes[holding] if holding.any() else boxes


def _midmost(places: FloatArray, boxes: FloatArray) -> FloatArray | None:
    """Return that of (k, 2) places that is most in the midst of those in the largest box, or None where none is."""
    if not len(boxes):
        return None
    largest = np.argmax((boxes[:, 1] - boxes[:, 0]).prod(axis=1))
    held = places[_inside(boxes, places)[largest]]
    if not len(held):
        return None
    return np.asarray(held[np.argmin(((held - held.mean(axis=0)) ** 2).sum(axis=1))])
