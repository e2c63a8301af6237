"""A window on a run of a 3D world: the translucent scene, the agent, its way so far and what it sees.

It reads the records that the run appends, and nothing else, so that watching neither slows nor changes the run.
Keys: space plays and pauses, left and right go by a step, Home and End to the first and the latest, q closes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
import pyvista
from PIL import Image
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkImageMapper

from foundry.replay.following import Follower
from foundry.storing.store import RunFolder
from foundry.worlds.camera.eye.avatar import avatar_meshes, trail_meshes
from foundry.worlds.camera.eye.batches import scene_actors
from foundry.worlds.camera.eye.overview import ASIDE_DEG, INSET_WIDTH, LAYERS, SCENE_OPACITY, overview_camera
from foundry.worlds.camera.loading.polydata import byte_values
from foundry.worlds.camera.scene import Scene, UInt8Array

SIZE = (1280, 860)
TICK_MS = 100
TICKS_PER_STEP = 5
"""A run that is over is played at two steps a second; one that is going on is looked at as often."""

_FOREVER = 2**31 - 1
_MARGIN_PX = 12


def show(run: RunFolder, trusted: Sequence[str] = ()) -> None:
    """Show a run, its world built of foundry's classes and of trusted packages', until the user closes the window.

    Raises:
        InputError: the run has no records yet, or its world is not a 3D one.
    """
    Window(Follower(run, trusted)).open()


class Window:
    """The window; its actors are replaced when another step is to be shown."""

    def __init__(self, follower: Follower) -> None:
        self._follower = follower
        around = follower.redrawing.around
        self._height_m = around.settings.body.height
        self._plotter = _plotter(f"foundry: {follower.run.id}")
        self._plotter.set_background("white")
        self._plotter.disable_anti_aliasing()  # with it, peeling makes translucent surfaces vanish
        self._plotter.enable_depth_peeling(LAYERS)
        self._avatar = scene_actors(avatar_meshes(self._height_m))
        self._trail: list[Any] = []
        self._inset = _Inset()
        self._add([*scene_actors(around.scene.meshes, fade=SCENE_OPACITY), *self._avatar, self._inset.actor])
        self._aim(around.scene)
        self._ticks = 0

    def open(self) -> None:
        """Show the window until the user closes it."""
        self._show()
        for key, step in self._keys().items():
            self._plotter.add_key_event(key, step)
        self._plotter.add_timer_event(max_steps=_FOREVER, duration=TICK_MS, callback=self._tick)
        self._plotter.show()

    def _keys(self) -> dict[str, Callable[[], None]]:
        follower = self._follower
        return {
            "Left": lambda: self._go(follower.step - 1),
            "Right": lambda: self._go(follower.step + 1),
            "Home": lambda: self._go(0),
            "End": lambda: self._go(follower.last),
            "space": self._play,
        }

    def _play(self) -> None:
        follower = self._follower
        if follower.step == follower.last and follower.run.ended:
            follower.go(0)
        follower.playing = not follower.playing

    def _go(self, step: int) -> None:
        self._follower.go(step)
        self._show()

    def _tick(self, _: int) -> None:
        self._ticks += 1
        if self._ticks % TICKS_PER_STEP == 0 and self._follower.tick():
            self._show()

    def _show(self) -> None:
        frame = self._follower.frame()
        for actor in self._avatar:
            actor.SetPosition(*frame.foot)
            actor.SetOrientation(0.0, 0.0, frame.yaw_deg)
        for actor in self._trail:
            self._plotter.remove_actor(actor, render=False)
        self._trail = scene_actors(trail_meshes(frame.trail, self._height_m * 0.02))
        self._add(self._trail)
        if frame.inset is not None:
            self._inset.show(frame.inset, self._plotter.window_size[0])
        caption = f"{frame.caption}   ({self._follower.step} of {self._follower.last})"
        self._plotter.add_text(caption, position="upper_left", font_size=10, color="black", name="caption")
        self._plotter.render()

    def _add(self, actors: Iterable[Any]) -> None:
        for actor in actors:
            self._plotter.add_actor(actor, reset_camera=False, render=False)

    def _aim(self, scene: Scene) -> None:
        camera = overview_camera(scene.bounds, ASIDE_DEG)
        self._plotter.camera_position = [tuple(camera.eye), tuple(camera.target), tuple(camera.up)]
        self._plotter.camera.view_angle = camera.fov_deg
        self._plotter.reset_camera_clipping_range()


def _plotter(title: str) -> Any:
    return pyvista.Plotter(window_size=list(SIZE), title=title)


class _Inset:
    """A picture in the lower right corner, pixel by pixel."""

    def __init__(self) -> None:
        self._image = vtkImageData()
        mapper: Any = vtkImageMapper()
        mapper.SetInputData(self._image)
        mapper.SetColorWindow(255.0)
        mapper.SetColorLevel(127.5)
        self.actor: Any = vtkActor2D()
        self.actor.SetMapper(mapper)

    def show(self, picture: UInt8Array, window_width: int) -> None:
        """Show (h, w, 3) RGB, row 0 at the top."""
        width, height = INSET_WIDTH, round(picture.shape[0] * INSET_WIDTH / picture.shape[1])
        small = np.asarray(Image.fromarray(picture).resize((width, height), Image.Resampling.LANCZOS), np.uint8)
        self._image.SetDimensions(width, height, 1)
        self._image.GetPointData().SetScalars(byte_values(small[::-1].reshape(-1, 3)))
        self._image.Modified()
        self.actor.SetPosition(window_width - width - _MARGIN_PX, _MARGIN_PX)
