"""The things of a scene with a unique label, their visibility, and paths to them."""

from collections.abc import Mapping
from fnmatch import fnmatchcase
from functools import cached_property
from typing import Annotated, Any

import msgspec
import numpy as np
from numpy.random import Generator

from foundry.errors import InputError
from foundry.records import Pose
from foundry.worlds.camera.body.navigation import Field, TargetSurfaces
from foundry.worlds.camera.camera_settings import Positive, TargetSettings
from foundry.worlds.camera.eye.rendering import angles
from foundry.worlds.camera.loading.scene import FloatArray
from foundry.worlds.camera.surroundings import DRAWS, Surroundings, Target, foot_of, turn_between
from foundry.worlds.validation import read_settings


class ThingsSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The selection of things.

    Attributes:
        ignore: patterns of labels to leave out.
        largest: maximum length of a thing's longer side, seen from above, metres. Longer things, such as walls, have no
            clear place.
        pixels: minimum number of pixels of a visible thing in an image.
    """

    ignore: list[str]
    largest: Positive
    pixels: Annotated[int, msgspec.Meta(ge=1)]


class Things:
    """The things of a scene with a label that belongs to a single prim.

    Args:
        around: the scene.
        settings: the selection.

    Attributes:
        names: their labels, in alphabetical order.

    Raises:
        InputError: there are fewer than two things.
    """

    def __init__(self, around: Surroundings, settings: ThingsSettings) -> None:
        self._around, self._settings = around, settings
        self._surfaces: dict[str, TargetSurfaces] = {}
        self.names: tuple[str, ...] = tuple(sorted(filter(self._is_one, around.scene.labels)))
        if len(self.names) < 2:
            raise InputError(
                f"Scene '{around.settings.scene.asset}' has {len(self.names)} things with a unique label. This "
                "world needs two or more: label its prims (UsdSemantics labels, or kind = component; see `foundry "
                "scene info`), or change world.things."
            )

    def _is_one(self, label: str) -> bool:
        if len(self._around.scene.labels[label]) != 1:
            return False
        if any(fnmatchcase(label, pattern) for pattern in self._settings.ignore):
            return False
        corners = self._corners.get(label)
        return corners is not None and float(np.ptp(corners[:, :, :2], axis=(0, 1)).max()) <= self._settings.largest

    @cached_property
    def _corners(self) -> dict[str, FloatArray]:
        """Lowest and highest corners (n, 2, 3) of the meshes of each label, metres."""
        found: dict[str, list[FloatArray]] = {}
        for mesh in self._around.scene.meshes:
            if mesh.label is not None and len(mesh.points):
                box = np.array([mesh.points.min(axis=0), mesh.points.max(axis=0)])
                found.setdefault(mesh.label, []).append(box)
        return {label: np.array(boxes) for label, boxes in found.items()}

    def target(self, name: str, radius_m: float) -> Target:
        """Return a thing as a target, with the paths to it."""
        prims = list(self._around.scene.labels[name])
        return self._around.target(TargetSettings(name=name, prims=prims, radius=radius_m))

    def gap(self, name: str, pose: Pose) -> float:
        """Return the distance of a thing from a pose, seen from above, metres."""
        return self._of(name).gap(foot_of(pose))

    def aside(self, name: str, pose: Pose) -> float:
        """Return the angle from the heading to a thing's middle, degrees, left positive, -180..180."""
        return self.direction(name, pose)[0]

    def direction(self, name: str, pose: Pose) -> tuple[float, float]:
        """Return the angles of a thing's middle from the heading and the horizon, degrees, left and up positive."""
        yaw, pitch = angles(self._of(name).points.mean(axis=0) - self._around.eye(pose))
        return turn_between(pose.yaw, yaw), pitch

    @property
    def least_pixels(self) -> int:
        """Minimum number of pixels of a visible thing in an image."""
        return self._settings.pixels

    def pixels(self, pose: Pose) -> dict[str, int]:
        """Return each thing's number of visible pixels in the image from a pose."""
        found = dict.fromkeys(self.names, 0)
        for path, count in self._around.renderer().visible(self._around.eye(pose), pose.yaw, pose.pitch).items():
            label = self._around.labels.get(path)
            if label in found:
                found[label] += count
        return found

    def seen(self, pose: Pose) -> dict[str, int]:
        """Return the visible things from a pose, with their pixels."""
        return {name: count for name, count in self.pixels(pose).items() if count >= self.least_pixels}

    def _of(self, name: str) -> TargetSurfaces:
        if name not in self._surfaces:
            paths = [path for path, label in self._around.labels.items() if label == name]
            self._surfaces[name] = self._around.navigator.target(paths)
        return self._surfaces[name]


class WaySettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """The selection of paths: their length, metres, and the distance to the thing that counts as reached, metres."""

    shortest: Positive
    longest: Positive
    radius: Positive


def read_way(values: Mapping[str, Any]) -> WaySettings:
    """Return the selection of paths.

    Raises:
        InputError: a setting is unknown or out of range.
    """
    way = read_settings(WaySettings, values, "world.way")
    if way.shortest > way.longest:
        raise InputError(f"world.way.shortest={way.shortest:g} is above longest={way.longest:g}. Swap them.")
    return way


def draw_way(
    around: Surroundings, things: Things, settings: WaySettings, goals: Generator, starts: Generator
) -> tuple[Target, Pose]:
    """Return the target of a drawn path and the first pose.

    Raises:
        InputError: the scene has no path of this length.
    """
    for _ in range(DRAWS):
        name = things.names[int(goals.integers(len(things.names)))]
        target = things.target(name, settings.radius)
        ways = _of_length(target.ways, settings)
        if np.isfinite(ways.distance).any():
            start = around.draw_start(starts, target, ways)
            length = around.way(start, target).length
            if length is not None and settings.shortest <= length <= settings.longest:
                return target, start
    length_m = f"{settings.shortest:g} to {settings.longest:g} m"
    raise InputError(
        f"Scene '{around.settings.scene.asset}' has no path of {length_m} to any of its {len(things.names)} things. "
        "Change world.way or world.start."
    )


def _of_length(ways: Field, settings: WaySettings) -> Field:
    """Return the paths without those that are too short or too long."""
    fits = (ways.distance >= settings.shortest) & (ways.distance <= settings.longest)
    return Field(np.where(fits, ways.distance, np.inf), ways.following)
