"""A window on a run: what it shows is its form's, how one goes through the steps is the same for all.

It reads the records that the run appends, and nothing else, so that watching neither slows nor changes the run.
Keys: space plays and pauses, left and right go by a step, Home and End to the first and the latest, q closes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import pyvista
from PIL import Image
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingCore import vtkActor2D, vtkImageMapper

from foundry.naming import in_room
from foundry.replay.following import Follower
from foundry.storing.store import RunFolder
from foundry.worlds.camera.loading.meshes import byte_values

SIZE = (1280, 860)
TICK_MS = 100
TICKS_PER_STEP = 5
"""A run that is over is played at two steps a second; one that is going on is looked at as often."""

_FOREVER = 2**31 - 1


def show(run: RunFolder, trusted: Sequence[str] = ()) -> None:
    """Show a run, its world built of foundry's classes and of trusted packages', until the user closes the window.

    Raises:
        InputError: the run has no records yet, or its world cannot draw them.
    """
    window_of(run, trusted).open()


def window_of(run: RunFolder, trusted: Sequence[str] = ()) -> Window:
    """Return the window of a run: that of its form, else one of the pictures that its world draws.

    Raises:
        InputError: the run has no records yet, or its world cannot draw them.
    """
    kind = _shipped(run.declared.form) or _shipped("any")
    assert kind is not None, "the window of any form is shipped"
    return kind(Follower(run, trusted))


def _shipped(form: str) -> Callable[[Follower], Window] | None:
    found: Callable[[Follower], Window] | None = in_room(f"foundry.viewer.{form}.{form}_window", "WINDOW")
    return found


class Window(ABC):
    """The window; what it shows is replaced when another step is to be shown."""

    def __init__(self, follower: Follower) -> None:
        self._follower = follower
        self._plotter: Any = pyvista.Plotter(window_size=list(SIZE), title=f"foundry: {follower.run.id}")
        self._plotter.set_background("white")
        self._ticks = 0

    @abstractmethod
    def draw(self) -> str:
        """Put the step that is shown into the window; returns what is to be said of it."""

    def open(self) -> None:
        """Show the window until the user closes it."""
        self.show()
        for key, step in self._keys().items():
            self._plotter.add_key_event(key, step)
        self._plotter.add_timer_event(max_steps=_FOREVER, duration=TICK_MS, callback=self._tick)
        self._plotter.show()

    def show(self) -> None:
        """Show the step where the viewer is."""
        follower = self._follower
        caption = f"{self.draw()}   ({follower.step} of {follower.last})"
        self._plotter.add_text(caption, position="upper_left", font_size=10, color="black", name="caption")
        self._plotter.render()

    def seen(self) -> npt.NDArray[np.uint8]:
        """Return what the window shows, (h, w, 3)."""
        return np.asarray(self._plotter.screenshot(return_img=True), np.uint8)

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
        self.show()

    def _tick(self, _: int) -> None:
        self._ticks += 1
        if self._ticks % TICKS_PER_STEP == 0 and self._follower.tick():
            self.show()

    def _add(self, actors: Iterable[Any]) -> None:
        for actor in actors:
            self._plotter.add_actor(actor, reset_camera=False, render=False)


class FlatPicture:
    """A picture that lies on the window, pixel by pixel.

    Attributes:
        actor: what the plotter shows.
    """

    def __init__(self) -> None:
        self._image = vtkImageData()
        mapper: Any = vtkImageMapper()
        mapper.SetInputData(self._image)
        mapper.SetColorWindow(255.0)
        mapper.SetColorLevel(127.5)
        self.actor: Any = vtkActor2D()
        self.actor.SetMapper(mapper)

    def show(self, picture: npt.NDArray[np.uint8], corner: tuple[int, int], size: tuple[int, int]) -> None:
        """Show (h, w, 3) RGB, row 0 at the top, stretched to a size and with its lower left corner here, pixels."""
        small = np.asarray(Image.fromarray(picture).resize(size, Image.Resampling.LANCZOS), np.uint8)
        self._image.SetDimensions(*size, 1)
        self._image.GetPointData().SetScalars(byte_values(small[::-1].reshape(-1, 3)))
        self._image.Modified()
        self.actor.SetPosition(*corner)
