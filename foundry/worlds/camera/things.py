"""The things of a scene with unique labels: where images show them, and paths to them."""

from collections.abc import Mapping, Sequence
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
from foundry.worlds.camera.camera_world import CameraScenario
from foundry.worlds.camera.eye.rendering import angles
from foundry.worlds.camera.loading.scene import FloatArray
from foundry.worlds.camera.surroundings import DRAWS, Surroundings, Target, foot_of, turn_between
from foundry.worlds.validation import read_settings


class ThingsSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Rules for the labelled things of a scene: which of them count, and how large a thing must be to count as seen.

    Attributes:
        ignore: patterns of labels to leave out.
        largest: largest length of a thing's longer side, seen from above, metres. Longer things, such as walls, have no
            clear place.
        pixels: smallest number of pixels with which an image shows a thing.
    """

    ignore: list[str]
    largest: Positive
    pixels: Annotated[int, msgspec.Meta(ge=1)]


class Things:
    """The things of a scene whose label belongs to one prim only.

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
        corners: dict[str, list[FloatArray]] = {}
        for mesh in self._around.scene.meshes:
            if mesh.label is not None and len(mesh.points):
                box = np.array([mesh.points.min(axis=0), mesh.points.max(axis=0)])
                corners.setdefault(mesh.label, []).append(box)
        return {label: np.array(boxes) for label, boxes in corners.items()}

    def target(self, name: str, radius_m: float) -> Target:
        """Return the thing with this label as a target, with the paths to it."""
        prims = list(self._around.scene.labels[name])
        return self._around.target(TargetSettings(name=name, prims=prims, radius=radius_m))

    def gap(self, name: str, pose: Pose) -> float:
        """Return the distance of a thing from a pose, seen from above, metres."""
        return self._of(name).gap(foot_of(pose))

    def aside(self, name: str, pose: Pose) -> float:
        """Return the angle from a pose's heading to a thing's middle, degrees, left positive, -180..180."""
        return self.direction(name, pose)[0]

    def direction(self, name: str, pose: Pose) -> tuple[float, float]:
        """Return the direction of a thing's middle: left of the heading, and above the horizon, both in degrees."""
        yaw, pitch = angles(self._of(name).points.mean(axis=0) - self._around.eye(pose))
        return turn_between(pose.yaw, yaw), pitch

    @property
    def least_pixels(self) -> int:
        """Smallest number of pixels with which an image shows a thing."""
        return self._settings.pixels

    def pixels(self, pose: Pose) -> dict[str, int]:
        """Return the number of pixels of each thing in the image from a pose."""
        counts = dict.fromkeys(self.names, 0)
        for path, count in self._around.renderer().visible(self._around.eye(pose), pose.yaw, pose.pitch).items():
            label = self._around.labels.get(path)
            if label in counts:
                counts[label] += count
        return counts

    def seen(self, pose: Pose) -> dict[str, int]:
        """Return the things that the image from a pose shows, with their numbers of pixels."""
        return {name: count for name, count in self.pixels(pose).items() if count >= self.least_pixels}

    def _of(self, name: str) -> TargetSurfaces:
        if name not in self._surfaces:
            paths = [path for path, label in self._around.labels.items() if label == name]
            self._surfaces[name] = self._around.navigator.target(paths)
        return self._surfaces[name]


class WaySettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """Limits on a path's length, and the distance at which the thing at its end counts as reached, all in metres."""

    shortest: Positive
    longest: Positive
    radius: Positive


class ThingsScenario(CameraScenario):
    """A 3D world whose goals are labelled things of the scene; the settings name no targets."""

    def __init__(self, *, way: Mapping[str, Any], things: Mapping[str, Any], **settings: Any) -> None:
        self.way = read_settings(WaySettings, way, "world.way")
        if self.way.shortest > self.way.longest:
            raise InputError(
                f"world.way.shortest={self.way.shortest:g} is above longest={self.way.longest:g}. Swap the two values."
            )
        super().__init__(**settings)
        if self.settings.targets:
            raise InputError(
                "world.targets is not a setting of this world, whose goals are labelled things. Remove it."
            )
        self.things = Things(self.surroundings, read_settings(ThingsSettings, things, "world.things"))

    def notes(self) -> Sequence[str]:
        """Return no notes; the note on missing targets is only for worlds whose settings name targets."""
        return ()

    def draw_way(self, goals: Generator, starts: Generator) -> tuple[Target, Pose]:
        """Return a random thing as the target of a path, and the first pose.

        Raises:
            InputError: the scene has no path of the right length.
        """
        around, way, names = self.surroundings, self.way, self.things.names
        for _ in range(DRAWS):
            target = self.things.target(names[int(goals.integers(len(names)))], way.radius)
            fits = (target.ways.distance >= way.shortest) & (target.ways.distance <= way.longest)
            if fits.any():
                ways = Field(np.where(fits, target.ways.distance, np.inf), target.ways.following)
                start = around.draw_start(starts, target, ways)
                length = around.way(start, target).length
                if length is not None and way.shortest <= length <= way.longest:
                    return target, start
        raise InputError(
            f"Scene '{around.settings.scene.asset}' has no path of {way.shortest:g} to {way.longest:g} m to any of its "
            f"{len(names)} things. Change world.way or world.start."
        )
