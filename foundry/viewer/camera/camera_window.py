"""A window on a run of a 3D world: the translucent scene, the agent, its way so far and what it sees."""

from __future__ import annotations

from typing import Any

from foundry.errors import InputError
from foundry.replay.following import Follower
from foundry.replay.window import FlatPicture, Window
from foundry.worlds.camera.eye.overview import (
    ASIDE_DEG,
    INSET_WIDTH,
    LAYERS,
    SCENE_OPACITY,
    avatar_meshes,
    overview_camera,
    trail_meshes,
)
from foundry.worlds.camera.eye.rendering import scene_actors
from foundry.worlds.camera.loading.scene import Scene
from foundry.worlds.camera.redrawing import CameraRedrawing

_MARGIN_PX = 12


class CameraWindow(Window):
    """The window; its actors are replaced when another step is to be shown."""

    def __init__(self, follower: Follower) -> None:
        super().__init__(follower)
        around = self._redrawing().around
        self._height_m = around.settings.body.height
        self._plotter.disable_anti_aliasing()  # with it, peeling makes translucent surfaces vanish
        self._plotter.enable_depth_peeling(LAYERS)
        self._avatar = scene_actors(avatar_meshes(self._height_m))
        self._trail: list[Any] = []
        self._inset = FlatPicture()
        self._add([*scene_actors(around.scene.meshes, fade=SCENE_OPACITY), *self._avatar, self._inset.actor])
        self._aim(around.scene)

    def _redrawing(self) -> CameraRedrawing:
        redrawing = self._follower.redrawing
        if not isinstance(redrawing, CameraRedrawing):
            raise InputError(f"The world of run '{self._follower.run.id}' draws no 3D scene: --window shows nothing.")
        return redrawing

    def draw(self) -> str:
        """Put the step that is shown into the window; returns its caption."""
        frame = self._redrawing().frame(self._follower.step)
        for actor in self._avatar:
            actor.SetPosition(*frame.foot)
            actor.SetOrientation(0.0, 0.0, frame.yaw_deg)
        for actor in self._trail:
            self._plotter.remove_actor(actor, render=False)
        self._trail = scene_actors(trail_meshes(frame.trail, self._height_m * 0.02))
        self._add(self._trail)
        if frame.inset is not None:
            width, height = INSET_WIDTH, round(frame.inset.shape[0] * INSET_WIDTH / frame.inset.shape[1])
            corner = (self._plotter.window_size[0] - width - _MARGIN_PX, _MARGIN_PX)
            self._inset.show(frame.inset, corner, (width, height))
        return frame.caption

    def _aim(self, scene: Scene) -> None:
        camera = overview_camera(scene.bounds, ASIDE_DEG)
        self._plotter.camera_position = [tuple(camera.eye), tuple(camera.target), tuple(camera.up)]
        self._plotter.camera.view_angle = camera.fov_deg
        self._plotter.reset_camera_clipping_range()


WINDOW = CameraWindow
