"""Draws a scene in an off-screen VTK window: the first-person view and its visible meshes."""

import io
import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (registers the window and the mappers)
from PIL import Image
from vtkmodules.util import numpy_support
from vtkmodules.vtkCommonCore import vtkUnsignedCharArray
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkPolyDataMapper,
    vtkRenderer,
    vtkRenderWindow,
    vtkTexture,
)

from foundry.worlds.camera.eye.devices import check_rendering, choose_window
from foundry.worlds.camera.loading.meshes import byte_values, corner_normals, floats, polydata
from foundry.worlds.camera.loading.scene import Colour, FloatArray, Scene, SceneMesh, UInt8Array


def direction(yaw_deg: float, pitch_deg: float) -> FloatArray:
    """Return the unit vector (3,) of a direction: heading and pitch, degrees."""
    yaw, pitch = np.radians(yaw_deg), np.radians(pitch_deg)
    return np.array([np.cos(pitch) * np.cos(yaw), np.cos(pitch) * np.sin(yaw), np.sin(pitch)])


def angles(offset: Sequence[float] | FloatArray) -> tuple[float, float]:
    """Return the heading and the pitch, degrees, at which a point with this offset (3,) from the eye is seen."""
    x, y, z = offset
    return math.degrees(math.atan2(y, x)) % 360.0, math.degrees(math.atan2(z, math.hypot(x, y)))


def offsets_from(eye: FloatArray, ahead: FloatArray, up: FloatArray, points: FloatArray) -> FloatArray:
    """Return how far points (..., 3) are right of, above and ahead of the eye, metres; the axes are unit vectors."""
    axes = np.column_stack([np.cross(ahead, up), up, ahead])
    return np.asarray((points - eye) @ axes)


def in_picture(offsets: FloatArray, frame: tuple[int, int], fov_deg: float) -> FloatArray:
    """Return the pixels (..., 2), right and down, of points with offsets (..., 3) by `offsets_from`; all must be ahead.

    `frame` is the width and height of the picture, pixels; `fov_deg` its vertical field of view.
    """
    scale = frame[1] / 2 / np.tan(np.radians(fov_deg) / 2) / offsets[..., 2]
    return np.stack([frame[0] / 2 + offsets[..., 0] * scale, frame[1] / 2 - offsets[..., 1] * scale], axis=-1)


_WRAPS = {"repeat": vtkTexture.Repeat, "mirror": vtkTexture.MirroredRepeat, "clamp": vtkTexture.ClampToEdge}


@dataclass(frozen=True, eq=False)
class Camera:
    """The position and direction of a camera, metres; `fov_deg` is its vertical field of view."""

    eye: FloatArray
    target: FloatArray
    up: FloatArray
    fov_deg: float
    near_m: float
    far_m: float

    def farther(self, factor: float) -> "Camera":
        """Return the camera with its distance from the target multiplied by a factor."""
        more = (factor - 1) * float(np.linalg.norm(self.eye - self.target))
        eye = self.target + (self.eye - self.target) * factor
        return replace(self, eye=eye, near_m=self.near_m + more, far_m=self.far_m + more)


class Canvas:
    """A hidden window of fixed size; only the thread that made the window may draw on it."""

    def __init__(self, width: int, height: int, *, samples: int, background: Colour = (0.0, 0.0, 0.0)) -> None:
        choose_window()
        self.width, self.height = width, height
        self._thread = threading.get_ident()
        self._pixels = vtkUnsignedCharArray()
        self._window: Any = vtkRenderWindow()
        self._window.SetOffScreenRendering(1)
        self._window.SetMultiSamples(samples)
        self._window.SwapBuffersOff()  # pictures are read from the buffer itself, so no copy for a screen is needed
        self._window.SetSize(width, height)
        self.renderer: Any = vtkRenderer()
        self.renderer.SetBackground(*background)
        self.renderer.AutomaticLightCreationOff()
        self._window.AddRenderer(self.renderer)

    def capabilities(self) -> str:
        """Draw once, and return the name and version of the OpenGL renderer."""
        self._window.Render()
        lines = self._window.ReportCapabilities().splitlines()
        wanted = ("OpenGL renderer string", "OpenGL version string")
        return ", ".join(line.split(":", 1)[1].strip() for line in lines if line.startswith(wanted))

    def peel(self, layers: int) -> None:
        """Draw translucent surfaces in their correct order; needs a window without multisampling."""
        self._window.SetAlphaBitPlanes(1)
        self.renderer.SetUseDepthPeeling(1)
        self.renderer.SetMaximumNumberOfPeels(layers)
        self.renderer.SetOcclusionRatio(0.0)

    def draw(self, camera: Camera) -> UInt8Array:
        """Return the camera's view as (h, w, 3) RGB, row 0 at the top."""
        if threading.get_ident() != self._thread:
            raise RuntimeError("Only the thread that made a canvas can draw on it; in another one it stays black.")
        lens = self.renderer.GetActiveCamera()
        lens.SetPosition(*camera.eye)
        lens.SetFocalPoint(*camera.target)
        lens.SetViewUp(*camera.up)
        lens.SetViewAngle(camera.fov_deg)
        lens.SetClippingRange(camera.near_m, camera.far_m)
        self._window.Render()
        self._window.GetPixelData(0, 0, self.width - 1, self.height - 1, 0, self._pixels, 0)
        pixels = np.asarray(_SUPPORT.vtk_to_numpy(self._pixels)).reshape(self.height, self.width, -1)
        return np.ascontiguousarray(pixels[::-1, :, :3], np.uint8)


def actor(data: Any, *, opacity: float = 1.0) -> Any:
    """Return an actor that draws a vtkPolyData in the exact colours of its scalars."""
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
    # More than 1 takes minutes on software OpenGL if a texture is repeated very often.
    made.SetMaximumAnisotropicFiltering(1)
    return made


LEAST_OPACITY = 0.5
"""Opacity from which on a surface hides the things behind it."""


def scene_actors(meshes: Sequence[SceneMesh], *, fade: float = 1.0) -> list[Any]:
    """Return VTK's actors for the meshes, opaque meshes first; the opacity of all meshes is multiplied by `fade`."""
    return [_batch_actor([with_normals(mesh) for mesh in batch], fade) for batch in batches(meshes)]


def batches(meshes: Sequence[SceneMesh]) -> list[list[SceneMesh]]:
    """Return the visible meshes in groups that are drawn in one piece each; opaque groups come first."""
    batch_meshes: dict[tuple[object, ...], list[SceneMesh]] = {}
    for mesh in meshes:
        if mesh.opacity > 0:
            batch_meshes.setdefault((mesh.opacity, id(mesh.texture), mesh.wrap), []).append(mesh)
    return sorted(batch_meshes.values(), key=lambda batch: -batch[0].opacity)


def id_actor(meshes: Sequence[SceneMesh]) -> Any:
    """Return an actor that draws each mesh in a colour of its own: its index in the sequence plus 1, as RGB."""
    hiding = [(number + 1, mesh) for number, mesh in enumerate(meshes) if mesh.opacity >= LEAST_OPACITY]
    if not hiding:
        return actor(polydata(np.zeros((0, 3)), np.zeros((0, 3), np.int64)))
    data = _joined([mesh for _, mesh in hiding])
    colours = [np.tile(_id_colour(number), (len(mesh.triangles), 1)) for number, mesh in hiding]
    data.GetCellData().SetScalars(byte_values(np.concatenate(colours)))
    return actor(data)


def ids_of(image: UInt8Array) -> npt.NDArray[np.int64]:
    """Return, for each pixel (h, w) of a picture drawn with `id_actor`, the number of its mesh; 0 without a mesh."""
    return np.asarray(image.astype(np.int64) @ np.array([65536, 256, 1]))


def with_normals(mesh: SceneMesh) -> SceneMesh:
    """Return the mesh, with computed normals if it has none."""
    if mesh.normals is not None:
        return mesh
    corners = mesh.triangles.ravel()
    return replace(
        mesh,
        points=mesh.points[corners],
        triangles=np.arange(len(corners)).reshape(-1, 3),
        normals=corner_normals(mesh.points, mesh.triangles).reshape(-1, 3),
        uvs=None if mesh.uvs is None else mesh.uvs[corners],
        vertex_colours=None if mesh.vertex_colours is None else mesh.vertex_colours[corners],
    )


def _batch_actor(meshes: Sequence[SceneMesh], fade: float) -> Any:
    first = meshes[0]
    data = _joined(meshes)
    values = data.GetPointData()
    values.SetScalars(byte_values(np.concatenate([lit_colours(mesh) for mesh in meshes])))
    made = actor(data, opacity=first.opacity * fade)
    if first.texture is not None:
        blank = (np.zeros((len(mesh.points), 2)) if mesh.uvs is None else mesh.uvs for mesh in meshes)
        values.SetTCoords(floats(np.concatenate(list(blank))))
        made.SetTexture(vtk_texture(first.texture, first.wrap))
    return made


def _joined(meshes: Sequence[SceneMesh]) -> Any:
    starts = np.cumsum([0, *(len(mesh.points) for mesh in meshes[:-1])])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=True)]
    return polydata(np.concatenate([mesh.points for mesh in meshes]), np.concatenate(triangles))


def lit_colours(mesh: SceneMesh) -> UInt8Array:
    """Return the colours (n, 3) of a mesh's points under the scene's light, plus the light that the points emit."""
    assert mesh.normals is not None
    own: FloatArray = np.array([mesh.colour]) if mesh.vertex_colours is None else mesh.vertex_colours / 255.0
    shown: FloatArray = np.clip(own * brightness(mesh.normals)[:, None] + np.array(mesh.emissive), 0, 1)
    return np.round(shown * 255).astype(np.uint8)


def _id_colour(number: int) -> UInt8Array:
    return np.array([number >> 16 & 255, number >> 8 & 255, number & 255], np.uint8)


_AMBIENT = 0.6
"""Brightness of the light that comes equally from all directions, 0..1."""

_LIGHTS = np.array([[0.32, 0.18, 0.25], [0.02, 0.10, 0.40]])
"""Light from +X, +Y, +Z, and from -X, -Y, -Z, so that the six sides of a room differ in brightness."""


def brightness(normals: FloatArray) -> FloatArray:
    """Return the (n,) brightness of surfaces with these (n, 3) unit normals; at most 1.

    The brightness is computed once for each point of a scene. With VTK's lights, a picture would take half as long
    again.
    """
    lit = np.clip(normals, 0, None) @ _LIGHTS[0] + np.clip(-normals, 0, None) @ _LIGHTS[1]
    return np.asarray(np.minimum(_AMBIENT + lit, 1.0))


SAMPLES = 4
"""Samples per pixel of the view: several, for smooth edges, and as many on every machine, so that pictures agree."""

SKY: Colour = (0.62, 0.70, 0.78)
"""Background colour, where a picture shows no surface."""

_NEAREST_M, _NEAR_AT_MOST_M, _DEPTH_RATIO = 0.02, 0.1, 20_000

_LOCAL = threading.local()

_SUPPORT: Any = numpy_support


class Renderer:
    """Draws one scene in pictures of one size; only the thread that made the object may use it."""

    def __init__(self, scene: Scene, *, width: int, height: int, fov_deg: float) -> None:
        check_rendering()
        self._scene, self._fov_deg = scene, fov_deg
        self._view = Canvas(width, height, samples=SAMPLES, background=SKY)
        for made in scene_actors(scene.meshes):
            self._view.renderer.AddActor(made)
        self._ids: Canvas | None = None

    def view(self, eye: FloatArray, yaw_deg: float, pitch_deg: float) -> UInt8Array:
        """Return the view from the eye (3,), metres, as (h, w, 3) RGB, row 0 at the top."""
        return self._view.draw(self._camera(eye, yaw_deg, pitch_deg))

    def visible(self, eye: FloatArray, yaw_deg: float, pitch_deg: float) -> dict[str, int]:
        """Return the number of pixels in which each visible mesh is seen, by the mesh's path.

        Mostly transparent meshes hide nothing and are not counted.
        """
        if self._ids is None:
            self._ids = Canvas(self._view.width, self._view.height, samples=0)
            self._ids.renderer.AddActor(id_actor(self._scene.meshes))
        ids = ids_of(self._ids.draw(self._camera(eye, yaw_deg, pitch_deg)))
        counts = np.bincount(ids.ravel(), minlength=len(self._scene.meshes) + 1)[1:]
        pixels: dict[str, int] = {}
        for number in np.flatnonzero(counts):
            path = self._scene.meshes[number].path
            pixels[path] = pixels.get(path, 0) + int(counts[number])
        return pixels

    def capabilities(self) -> str:
        """Return the name and version of the renderer, for the log."""
        return self._view.capabilities()

    def _camera(self, eye: FloatArray, yaw_deg: float, pitch_deg: float) -> Camera:
        corners = self._scene.bounds
        far = float(np.linalg.norm(np.abs(corners - eye).max(axis=0))) * 1.01 + 1
        near = min(max(_NEAREST_M, far / _DEPTH_RATIO), _NEAR_AT_MOST_M)
        ahead = direction(yaw_deg, pitch_deg)
        return Camera(eye, eye + ahead, direction(yaw_deg, pitch_deg + 90), self._fov_deg, near, far)


def renderer_for(scene: Scene, *, width: int, height: int, fov_deg: float) -> Renderer:
    """Return this thread's renderer for the scene.

    Only the latest renderer of a thread is cached, so call this function whenever you need one. Making a renderer takes
    as long as drawing fifty pictures.
    """
    key = (scene, width, height, fov_deg)
    if getattr(_LOCAL, "key", None) != key:
        _LOCAL.key = _LOCAL.renderer = None  # frees the window of the previous renderer first
        _LOCAL.renderer = Renderer(scene, width=width, height=height, fov_deg=fov_deg)
        _LOCAL.key = key
    renderer: Renderer = _LOCAL.renderer
    return renderer


def png(image: UInt8Array) -> bytes:
    """Return a picture (h, w, 3) encoded as PNG; the same pixels give the same bytes."""
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, "PNG", compress_level=6)
    return buffer.getvalue()
