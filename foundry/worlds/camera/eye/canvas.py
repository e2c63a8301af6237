"""An off-screen window of VTK: actors in, pixels out."""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (registers the window and the mappers)
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkTexture,
)

from foundry.worlds.camera.eye.glcheck import choose_window
from foundry.worlds.camera.loading.polydata import as_numpy, byte_values
from foundry.worlds.camera.loading.scene import Colour, FloatArray, UInt8Array

_WRAPS = {"repeat": vtkTexture.Repeat, "mirror": vtkTexture.MirroredRepeat, "clamp": vtkTexture.ClampToEdge}


@dataclass(frozen=True, eq=False)
class Camera:
    """Where a picture is taken from: metres; `fov_deg` is the vertical angle of view."""

    eye: FloatArray
    target: FloatArray
    up: FloatArray
    fov_deg: float
    near_m: float
    far_m: float

    def farther(self, factor: float) -> Camera:
        """Return the same camera so many times as far from what it looks at."""
        more = (factor - 1) * float(np.linalg.norm(self.eye - self.target))
        eye = self.target + (self.eye - self.target) * factor
        return replace(self, eye=eye, near_m=self.near_m + more, far_m=self.far_m + more)


class Canvas:
    """A window of a fixed size that is never shown; only the thread that made it may draw on it."""

    def __init__(self, width: int, height: int, *, samples: int, background: Colour = (0.0, 0.0, 0.0)) -> None:
        choose_window()
        self.width, self.height = width, height
        self._thread = threading.get_ident()
        self._pixels = vtkUnsignedCharArray()
        self._window: Any = vtkRenderWindow()
        self._window.SetOffScreenRendering(1)
        self._window.SetMultiSamples(samples)
        self._window.SwapBuffersOff()  # pictures are read from where they are drawn, so no copy is made for a screen
        self._window.SetSize(width, height)
        self.renderer: Any = vtkRenderer()
        self.renderer.SetBackground(*background)
        self.renderer.AutomaticLightCreationOff()
        self._window.AddRenderer(self.renderer)

    def capabilities(self) -> str:
        """Return the name of the OpenGL renderer and its version, after drawing once."""
        self._window.Render()
        lines = self._window.ReportCapabilities().splitlines()
        wanted = ("OpenGL renderer string", "OpenGL version string")
        return ", ".join(line.split(":", 1)[1].strip() for line in lines if line.startswith(wanted))

    def peel(self, layers: int) -> None:
        """Draw translucent surfaces in their true order; needs a window without multisampling."""
        self._window.SetAlphaBitPlanes(1)
        self.renderer.SetUseDepthPeeling(1)
        self.renderer.SetMaximumNumberOfPeels(layers)
        self.renderer.SetOcclusionRatio(0.0)

    def draw(self, camera: Camera) -> UInt8Array:
        """Return what the camera sees as (h, w, 3) RGB, row 0 at the top."""
        if threading.get_ident() != self._thread:
            raise RuntimeError("A canvas was used from another thread than the one that made it; it would stay black.")
        self._aim(camera)
        self._window.Render()
        self._window.GetPixelData(0, 0, self.width - 1, self.height - 1, 0, self._pixels, 0)
        pixels = as_numpy(self._pixels).reshape(self.height, self.width, -1)
        return np.ascontiguousarray(pixels[::-1, :, :3], np.uint8)

    def _aim(self, camera: Camera) -> None:
        lens = self.renderer.GetActiveCamera()
        lens.SetPosition(*camera.eye)
        lens.SetFocalPoint(*camera.target)
        lens.SetViewUp(*camera.up)
        lens.SetViewAngle(camera.fov_deg)
        lens.SetClippingRange(camera.near_m, camera.far_m)


def actor(data: Any, *, opacity: float = 1.0) -> Any:
    """Return an actor of a vtkPolyData, in exactly the colours of its scalars."""
    mapper = vtkPolyDataMapper()
    mapper.SetInputData(data)
    mapper.SetColorModeToDirectScalars()
    made = vtkActor()
    made.SetMapper(mapper)
    made.GetProperty().LightingOff()
    made.GetProperty().SetOpacity(opacity)
    return made


def vtk_texture(picture: UInt8Array, wrap: str) -> Any:
    """Return a texture of an (h, w, 3 or 4) picture."""
    height, width, depth = picture.shape
    image = vtkImageData()
    image.SetDimensions(width, height, 1)
    image.GetPointData().SetScalars(byte_values(picture[::-1].reshape(-1, depth)))
    made = vtkTexture()
    made.SetInputData(image)
    made.SetColorModeToDirectScalars()
    made.SetWrap(_WRAPS[wrap])
    made.InterpolateOn()
    made.MipmapOn()
    # More than 1 takes minutes on software OpenGL where a texture is repeated very often.
    made.SetMaximumAnisotropicFiltering(1)
    return made
