"""Finds where a picture of a 3D run shows the target, and the direction of a target outside the picture."""

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
"""Smallest distance from the eye at which something is drawn, metres."""

_FOLLOWING = (1, 2, 0)
"""The number of the next corner, for each of a triangle's corners 0, 1 and 2."""


@dataclass(frozen=True, eq=False)
class Pointed:
    """The position of a target, seen from a pose, in fractions of the picture's size from its upper left corner.

    Attributes:
        boxes: (n, 2, 2) upper left and lower right corner of each separate part of the target within the picture. If
            some parts have a visible point, only these parts are listed.
        spot: (2,) a visible point of the target, or None.
        centred: whether the target's middle is within the picture, visible or not.
        turn: angle from the heading to the target's middle, degrees, left positive, -180..180.
        tilt: angle from the gaze to the target's middle, degrees, up positive.
    """

    boxes: FloatArray
    spot: FloatArray | None
    centred: bool
    turn: float
    tilt: float


class Pointer:
    """Finds where a target is in the picture that an agent sees at a pose.

    Args:
        prims: paths of the target's prims; everything below them belongs to the target.
        frame: width and height of the pictures, pixels.
        fov_deg: vertical field of view of the pictures, degrees.
        eye_height: height of the eye above the foot, metres.

    Attributes:
        middle: (3,) middle of the target's surfaces, metres.
        boxes: (n, 2, 3) lowest and highest corner of each separate part of the target, metres.
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
        self.boxes: FloatArray = joined(np.array([[corner.min(axis=0), corner.max(axis=0)] for corner in corners]))

    def seen_from(self, pose: Pose) -> Pointed:
        """Return where an agent at a pose sees the target: its place in the picture, and its direction."""
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
        """Return the picture positions (k, 2) of points at offsets (n, 3) from the eye; drop points behind the eye."""
        return in_picture(offsets[offsets[:, 2] >= NEAR_M], self._frame, self._fov_deg) / self._frame

    def _box(self, corners: FloatArray) -> FloatArray | None:
        """Return the box (2, 2) that triangles (n, 3, 3), as offsets from the eye, cover in the picture; else None."""
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
    """Return boxes (n, 2, k), lowest and highest corners, after merging boxes that overlap or touch."""
    if not len(boxes):
        return boxes
    low, high = boxes[:, 0], boxes[:, 1]
    touching = np.asarray((low[:, None] <= high).all(axis=2) & (low <= high[:, None]).all(axis=2))
    count, group = connected_components(touching, directed=False)
    groups = [group == number for number in range(count)]
    return np.array([[low[group].min(axis=0), high[group].max(axis=0)] for group in groups])


def _within(places: FloatArray) -> BoolArray:
    return np.asarray(((places >= 0) & (places <= 1)).all(axis=1))


def _inside(boxes: FloatArray, places: FloatArray) -> BoolArray:
    """Return whether each of (n, 2, 2) boxes contains each of (k, 2) places, (n, k)."""
    return np.asarray(((boxes[:, :1] <= places) & (places <= boxes[:, 1:])).all(axis=2))


def _holding(boxes: FloatArray, places: FloatArray) -> FloatArray:
    """Return the boxes that contain at least one of the places (k, 2); if no box does, return all boxes."""
    holding = _inside(boxes, places).any(axis=1)
    return boxes[holding] if holding.any() else boxes


def _midmost(places: FloatArray, boxes: FloatArray) -> FloatArray | None:
    """Return the most central of the places (k, 2) in the largest box, or None if this box contains no place."""
    if not len(boxes):
        return None
    largest = np.argmax((boxes[:, 1] - boxes[:, 0]).prod(axis=1))
    held = places[_inside(boxes, places)[largest]]
    if not len(held):
        return None
    return np.asarray(held[np.argmin(((held - held.mean(axis=0)) ** 2).sum(axis=1))])
