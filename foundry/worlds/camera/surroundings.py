"""A scene's geometry, obstacles, paths, targets and views, which all runs in a process share."""

import io
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import cached_property, lru_cache
from typing import Any

import msgspec
import numpy as np
from numpy.random import Generator
from PIL import Image

from foundry import paths
from foundry.errors import InputError, RecordError, not_found
from foundry.records import NOT_JSON, CameraEpisode, Pose
from foundry.worlds.camera.body.collision import Body, Collider
from foundry.worlds.camera.body.navigation import CELL_M, Field, Navigator, TargetSurfaces
from foundry.worlds.camera.camera_settings import CameraSettings, TargetSettings
from foundry.worlds.camera.eye.rendering import Renderer, png, renderer_for
from foundry.worlds.camera.loading.scene import FloatArray, UInt8Array
from foundry.worlds.camera.loading.stage import load_scene

POSE_DIGITS = 9
"""Decimal places of the numbers in a pose; rounding to these places does not change the image."""


def make_pose(foot: FloatArray, yaw: float, pitch: float) -> Pose:
    """Return the pose with this place (3,) of the foot, metres, heading and gaze, degrees."""
    x, y, z = (round(float(value), POSE_DIGITS) + 0.0 for value in foot)
    return Pose(x, y, z, round(yaw % 360.0, POSE_DIGITS) % 360.0, round(pitch, POSE_DIGITS) + 0.0)


def foot_of(pose: Pose) -> FloatArray:
    """Return the place of the foot in a pose, (3,), metres."""
    return np.array([pose.x, pose.y, pose.z])


def feet_of(poses: Iterable[Pose]) -> FloatArray:
    """Return the place of the foot in each of k poses, (k, 3), metres."""
    return np.array([foot_of(pose) for pose in poses])


def turn_between(before: float, after: float) -> float:
    """Return the turn from one heading to another, degrees, left positive, -180..180."""
    return (after - before + 180.0) % 360.0 - 180.0


CLEARANCE_M = 0.1
"""Smallest gap between the body and obstacles at the start, metres."""

ARRIVED_M = 0.03
"""An agent this close to a corner of a path, metres, has reached the corner, since no agent meets it exactly."""

DRAWS = 100
"""Maximum number of random draws until a suitable start or path is found."""


@dataclass(frozen=True, eq=False)
class Target:
    """A target.

    Attributes:
        name: the target's name in the task.
        paths: paths of the target's meshes.
        label: label of the target's meshes; None if they have no label or several.
        radius: distance that counts as reached, metres.
        ways: shortest paths to the goal: the cells that are near enough to the target and from which it is in line of
            sight.
    """

    name: str
    paths: tuple[str, ...]
    label: str | None
    radius: float
    surfaces: TargetSurfaces
    ways: Field


@dataclass(frozen=True, eq=False)
class Way:
    """The shortest path to a goal: its points (k, 3) and its length, metres; the length is None without a path."""

    points: FloatArray
    length: float | None

    @property
    def corners(self) -> list[list[float]]:
        """The points [x, y] to walk to, one after another, without points that the agent has reached."""
        gaps = np.hypot(*(self.points - self.points[:1])[:, :2].T)
        ahead = self.points[int(np.argmax(gaps > ARRIVED_M)) :] if (gaps > ARRIVED_M).any() else self.points[-1:]
        return [[float(x), float(y)] for x, y, _ in ahead]


class Surroundings:
    """A scene, the body and the eye of the agent in it, and the agent's targets."""

    def __init__(self, settings: CameraSettings) -> None:
        self.settings = settings
        self.scene = load_scene(settings.scene.asset, exclude=settings.scene.exclude, root=settings.scene.root)
        body = settings.body
        self.body = Body(body.radius, body.height, body.step_height)
        bounds = None if settings.bounds is None else np.array(settings.bounds, np.float64)
        self.collider = Collider(self.scene, bounds=bounds, floor_height=settings.floor)
        self._targets: dict[str, Target] = {}
        self._last_way: tuple[tuple[float, float, float], Target | None, Way] | None = None

    @cached_property
    def navigator(self) -> Navigator:
        """Finds paths for this body in this scene; made once, with its grid of cells cached on disk."""
        return Navigator(self.collider, self.body, cache=paths.scene_cache_dir())

    def episode(self, line: bytes) -> CameraEpisode:
        """Return the record of an episode in this scene, given its line of `episode.jsonl`.

        Raises:
            InputError: the episode was in another scene.
            RecordError: the line cannot be read.
        """
        try:
            episode = msgspec.json.decode(line, type=CameraEpisode)
        except NOT_JSON as error:
            raise RecordError(f"A line of episode.jsonl cannot be read: {error}") from error
        self.scene.check_digest(episode.scene_sha256)
        return episode

    def renderer(self) -> Renderer:
        """Return the renderer of the agent's views."""
        camera = self.settings.camera
        return renderer_for(self.scene, width=camera.width, height=camera.height, fov_deg=camera.fov)

    def draw_target(self, rng: Generator) -> Target | None:
        """Return one of the targets at random, or None if there are none."""
        targets = self.settings.targets
        return self.target(targets[int(rng.integers(len(targets)))]) if targets else None

    def target(self, settings: TargetSettings) -> Target:
        """Return a target and the paths to this target; the paths are computed only once."""
        if settings.name not in self._targets:
            self._targets[settings.name] = self._find_target(settings)
        return self._targets[settings.name]

    def _find_target(self, settings: TargetSettings) -> Target:
        chosen = {path for path in self.labels if any(is_below(path, pattern) for pattern in settings.prims)}
        if not chosen:
            known = [prim for prims in self.scene.labels.values() for prim in prims]
            raise not_found(
                f"Prim of target '{settings.name}'", ", ".join(settings.prims), known or sorted(self.labels)
            )
        surfaces = self.navigator.target(sorted(chosen))
        within = max(settings.radius - CELL_M, 0.0)  # so that the whole of a goal's cell is near enough
        goals = self.navigator.goal_cells(surfaces, within, self.settings.body.eye_height)
        labels = {self.labels[path] for path in chosen}
        return Target(
            name=settings.name,
            paths=tuple(sorted(chosen)),
            label=labels.pop() if len(labels) == 1 else None,
            radius=settings.radius,
            surfaces=surfaces,
            ways=self.navigator.distance_field(goals),
        )

    def draw_start(self, rng: Generator, target: Target | None, ways: Field | None = None) -> Pose:
        """Return the first pose, as configured or drawn from the start region.

        Args:
            rng: draws the start.
            target: the target, which the start must not be near.
            ways: paths, one of which must begin at the start. None means the paths to the target.
        """
        start = self.settings.start
        yaw = float(rng.uniform(0.0, 360.0)) if start.yaw is None else start.yaw
        if start.x is not None and start.y is not None:
            return make_pose(self._stand(start.x, start.y), yaw, start.pitch)
        for _ in range(DRAWS):
            foot = self._draw_foot(rng, target.ways if ways is None and target else ways)
            if target is None or target.surfaces.gap(foot) > target.radius:
                return make_pose(foot, yaw, start.pitch)
        raise InputError(
            f"Every start in world.start.region is already within {target.radius if target else 0} m of the target. "
            "Choose a region farther from it."
        )

    def _draw_foot(self, rng: Generator, ways: Field | None) -> FloatArray:
        start = self.settings.start
        box = self.collider.bounds[:, :2] if start.region is None else np.array(start.region, np.float64)
        clearance = self.body.radius_m + CLEARANCE_M
        return self.navigator.random_foot(rng, box, clearance_m=clearance, field=ways)

    def _stand(self, x: float, y: float) -> FloatArray:
        """Return the place (3,) of the foot of a body that stands at (x, y), metres."""
        start, (low, high) = self.settings.start, self.collider.bounds[:, :2]
        if not (low[0] <= x <= high[0] and low[1] <= y <= high[1]):
            raise InputError(
                f"The start x={x:g}, y={y:g} is outside the scene, which has x from {low[0]:.2f} to {high[0]:.2f} "
                f"and y from {low[1]:.2f} to {high[1]:.2f} m. Set world.start.x and world.start.y within it."
            )
        top = float(self.collider.bounds[1, 2]) if start.z is None else start.z
        height = self.collider.floor_below(np.array([x, y, top]), self.body)
        if height is None:
            raise InputError(
                f"There is no floor below the start ({x}, {y}, {top:g}). Correct world.start or world.floor."
            )
        foot = np.array([x, y, height])
        hit = self.collider.touching(foot, self.body)
        if hit is not None:
            raise InputError(f"At the start ({x}, {y}, {height:g}) the body is inside '{hit}'. Choose another place.")
        return foot

    def eye(self, pose: Pose) -> FloatArray:
        """Return the place of the eye (3,) at a pose, metres."""
        return np.array([pose.x, pose.y, pose.z + self.settings.body.eye_height])

    @cached_property
    def labels(self) -> dict[str, str | None]:
        """The label of each mesh, or None, by the mesh's path."""
        return {mesh.path: mesh.label for mesh in self.scene.meshes}

    def way(self, pose: Pose, target: Target | None) -> Way:
        """Return the shortest path from a pose to the goal; the latest path is cached."""
        place = (pose.x, pose.y, pose.z)
        if self._last_way is None or self._last_way[:2] != (place, target):
            route = self.navigator.path(foot_of(pose), target.ways) if target else None
            way = Way(np.zeros((0, 3)), None) if route is None else Way(route.points, float(route.length_m))
            self._last_way = (place, target, way)
        return self._last_way[2]


def surroundings_of(settings: CameraSettings) -> Surroundings:
    """Return the scene, paths and views for these settings, shared by runs and conditions; the latest are cached."""
    elsewhere: dict[str, Any] = {"name": "", "task": "", "steps": 1, "history": 0, "boundary": "", "keep_images": True}
    return _surroundings(msgspec.json.encode(msgspec.structs.replace(settings, **elsewhere)))


@lru_cache(maxsize=4)
def _surroundings(settings: bytes) -> Surroundings:
    return Surroundings(msgspec.json.decode(settings, type=CameraSettings))


def is_below(path: str, pattern: str) -> bool:
    """Return whether a pattern names a prim or one of its ancestors."""
    return fnmatchcase(path, pattern) or fnmatchcase(path, f"{pattern}/*")


JPEG_QUALITY = 90


@dataclass(frozen=True, eq=False)
class Sight:
    """The view from a pose, and facts about the pose and the view.

    Attributes:
        image: (h, w, 3) RGB.
        encoded: the image, encoded as sent to the model.
        visible_px: for each label in view, the number of pixels of its things.
        target_px: number of pixels of the target.
        distance: length of the shortest path to the goal, metres; None without a goal or a path to it.
        near: whether the foot is within the target's radius, without a wall in between.
        line_of_sight: whether a straight line from the eye reaches the target.
    """

    pose: Pose
    image: UInt8Array
    encoded: bytes
    visible_px: dict[str, int]
    target_px: int
    distance: float | None
    near: bool
    line_of_sight: bool

    @property
    def success(self) -> bool:
        """True if the agent is at the goal: near enough, and with the target in view."""
        return self.near and self.target_px > 0


def look(around: Surroundings, pose: Pose, target: Target | None) -> Sight:
    """Return the view from a pose, and facts about it."""
    eye, renderer, foot = around.eye(pose), around.renderer(), foot_of(pose)
    image = renderer.view(eye, pose.yaw, pose.pitch)
    pixels = renderer.visible(eye, pose.yaw, pose.pitch)
    by_label: Counter[str] = Counter()
    for path, count in pixels.items():
        if (label := around.labels.get(path)) is not None:
            by_label[label] += count
    clear = target is not None and around.navigator.line_of_sight(eye, target.surfaces)
    return Sight(
        pose=pose,
        image=image,
        encoded=_encoded(image, around.settings.image_format),
        visible_px=dict(sorted(by_label.items())),
        target_px=sum(pixels.get(path, 0) for path in target.paths) if target else 0,
        distance=_finite(around.navigator.distance(foot, target.ways)) if target else None,
        near=clear and target is not None and target.surfaces.gap(foot) <= target.radius,
        line_of_sight=clear,
    )


def encoded_view(around: Surroundings, pose: Pose) -> bytes:
    """Return the encoded view from a pose, as sent to the model."""
    image = around.renderer().view(around.eye(pose), pose.yaw, pose.pitch)
    return _encoded(image, around.settings.image_format)


def _encoded(image: UInt8Array, image_format: str) -> bytes:
    if image_format == "png":
        return png(image)
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, "JPEG", quality=JPEG_QUALITY)
    return buffer.getvalue()


def _finite(value: float) -> float | None:
    return round(float(value), 9) if np.isfinite(value) else None
