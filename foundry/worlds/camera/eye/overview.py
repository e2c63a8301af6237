"""The overview: the translucent scene from above or aside, with the agent, its way so far and what it sees."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from foundry.worlds.camera.eye.avatar import avatar_meshes, trail_meshes
from foundry.worlds.camera.eye.batches import scene_actors
from foundry.worlds.camera.eye.canvas import Camera, Canvas
from foundry.worlds.camera.eye.captions import captioned, inset_size, with_inset
from foundry.worlds.camera.eye.directions import direction
from foundry.worlds.camera.eye.insets import layout, shifted
from foundry.worlds.camera.loading.scene import Colour, FloatArray, Scene, UInt8Array

WIDTH, HEIGHT = 960, 720
ABOVE_DEG, ASIDE_DEG = 89.0, 32.0
"""How high the overview looks down from."""

_PAPER: Colour = (0.97, 0.97, 0.98)
SCENE_OPACITY = 0.22
LAYERS = 6
_FOV_DEG = 30.0
_TURN_DEG = 22.0
"""Turned this far out of the square view of the longer side, so that depth can be seen."""

INSET_WIDTH = 288


@dataclass(frozen=True, eq=False)
class OverviewFrame:
    """What one overview shows.

    Attributes:
        foot: (3,) where the agent stands, metres.
        yaw_deg: its heading.
        height_m: its height.
        trail: (k, 3) where it has stood, the first place first.
        caption: text along the top, such as the step and the command.
        inset: (h, w, 3) what the agent sees, or None.
        bounds: (2, 3) the part of the scene that must be in the picture, or None: all of it.
        elevation_deg: how high the picture is taken from; 90 is straight above.
    """

    foot: FloatArray
    yaw_deg: float
    height_m: float = 1.75
    trail: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))
    caption: str = ""
    inset: UInt8Array | None = None
    bounds: FloatArray | None = None
    elevation_deg: float = ASIDE_DEG


class Overview:
    """Draws overviews of one scene; only the thread that made it may use it."""

    def __init__(self, scene: Scene) -> None:
        self._bounds = scene.bounds
        self._canvas = Canvas(WIDTH, HEIGHT, samples=0, background=_PAPER)
        self._canvas.peel(LAYERS)
        for made in scene_actors(scene.meshes, fade=SCENE_OPACITY):
            self._canvas.renderer.AddActor(made)
        self._height_m = 0.0
        self._avatar: list[Any] = []

    def draw(self, frame: OverviewFrame) -> UInt8Array:
        """Return the overview as (h, w, 3) RGB, row 0 at the top."""
        bounds = self._bounds if frame.bounds is None else frame.bounds
        camera, placed = overview_camera(bounds, frame.elevation_deg), None
        if frame.inset is not None:
            placed = layout(camera, bounds, (WIDTH, HEIGHT), inset_size(frame.inset, INSET_WIDTH))
            camera = camera.farther(placed.zoom)
        self._place_avatar(frame)
        trail = scene_actors(trail_meshes(frame.trail, frame.height_m * 0.02))
        self._show(trail)
        image = self._canvas.draw(camera)
        self._hide(trail)
        if frame.inset is not None and placed is not None:
            image = with_inset(shifted(image, placed.shift), frame.inset, INSET_WIDTH, (placed.left, placed.top))
        return captioned(image, frame.caption)

    def _place_avatar(self, frame: OverviewFrame) -> None:
        if frame.height_m != self._height_m:
            self._hide(self._avatar)
            self._height_m, self._avatar = frame.height_m, scene_actors(avatar_meshes(frame.height_m))
            self._show(self._avatar)
        for actor in self._avatar:
            actor.SetPosition(*frame.foot)
            actor.SetOrientation(0.0, 0.0, frame.yaw_deg)

    def _show(self, actors: Iterable[Any]) -> None:
        for actor in actors:
            self._canvas.renderer.AddActor(actor)

    def _hide(self, actors: Iterable[Any]) -> None:
        for actor in actors:
            self._canvas.renderer.RemoveActor(actor)


def overview_camera(bounds: FloatArray, elevation_deg: float) -> Camera:
    """Return the camera that has the whole box in its picture, from the longer side."""
    size, centre = bounds[1] - bounds[0], bounds.mean(axis=0)
    facing = 90.0 if size[0] >= size[1] else 180.0
    yaw = facing + _TURN_DEG * (elevation_deg < ABOVE_DEG)
    ahead, up = direction(yaw, -elevation_deg), direction(yaw, 90 - elevation_deg)
    corners = np.array([[x, y, z] for x in bounds[:, 0] for y in bounds[:, 1] for z in bounds[:, 2]]) - centre
    slope = np.tan(np.radians(_FOV_DEG) / 2)
    aside = np.abs(corners @ np.cross(ahead, up)) / (slope * WIDTH / HEIGHT)
    high, deep = np.abs(corners @ up) / slope, corners @ ahead
    distance = float((np.maximum(aside, high) - deep).max()) * 1.08
    reach = float(np.linalg.norm(size))
    near = max(distance - 2 * reach, distance * 0.01)
    return Camera(centre - ahead * distance, centre, up, _FOV_DEG, near, distance + 2 * reach)
