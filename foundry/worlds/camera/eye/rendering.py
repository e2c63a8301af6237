"""Draws a scene: the first-person view, which meshes it shows, and the overview."""

from __future__ import annotations

import io
import threading

import numpy as np
from PIL import Image

from foundry.worlds.camera.eye.batches import id_actor, ids_of, scene_actors
from foundry.worlds.camera.eye.canvas import Camera, Canvas
from foundry.worlds.camera.eye.directions import direction
from foundry.worlds.camera.eye.glcheck import check_rendering
from foundry.worlds.camera.eye.overview import Overview, OverviewFrame
from foundry.worlds.camera.loading.scene import Colour, FloatArray, Scene, UInt8Array

SAMPLES = 4
"""Multisampling of the view: the same pixels everywhere, and no stairs on edges."""

SKY: Colour = (0.62, 0.70, 0.78)
"""What is seen where the scene ends."""

_NEAREST_M, _NEAR_AT_MOST_M, _DEPTH_RATIO = 0.02, 0.1, 20_000

_LOCAL = threading.local()


class Renderer:
    """Draws one scene in pictures of one size; only the thread that made it may use it."""

    def __init__(self, scene: Scene, *, width: int, height: int, fov_deg: float) -> None:
        check_rendering()
        self._scene, self._fov_deg = scene, fov_deg
        self._view = Canvas(width, height, samples=SAMPLES, background=SKY)
        for made in scene_actors(scene.meshes):
            self._view.renderer.AddActor(made)
        self._ids: Canvas | None = None
        self._overview: Overview | None = None

    def view(self, eye: FloatArray, yaw_deg: float, pitch_deg: float) -> UInt8Array:
        """Return what is seen from the eye (3,), metres, as (h, w, 3) RGB, row 0 at the top."""
        return self._view.draw(self._camera(eye, yaw_deg, pitch_deg))

    def visible(self, eye: FloatArray, yaw_deg: float, pitch_deg: float) -> dict[str, int]:
        """Return how many pixels of the view each mesh fills, by mesh path; those it fills none of are left out.

        What lets most light through hides nothing and counts nothing.
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

    def overview(self, frame: OverviewFrame) -> UInt8Array:
        """Return the translucent scene with the agent in it, seen from outside, as (h, w, 3) RGB."""
        if self._overview is None:
            self._overview = Overview(self._scene)
        return self._overview.draw(frame)

    def capabilities(self) -> str:
        """Return the name and version of what draws, for the log."""
        return self._view.capabilities()

    def _camera(self, eye: FloatArray, yaw_deg: float, pitch_deg: float) -> Camera:
        corners = self._scene.bounds
        far = float(np.linalg.norm(np.abs(corners - eye).max(axis=0))) * 1.01 + 1
        near = min(max(_NEAREST_M, far / _DEPTH_RATIO), _NEAR_AT_MOST_M)
        ahead = direction(yaw_deg, pitch_deg)
        return Camera(eye, eye + ahead, direction(yaw_deg, pitch_deg + 90), self._fov_deg, near, far)


def renderer_for(scene: Scene, *, width: int, height: int, fov_deg: float) -> Renderer:
    """Return this thread's renderer for the scene; made once, since making one takes as long as fifty pictures.

    Only the latest is kept, so ask for it whenever one is needed.
    """
    key = (scene, width, height, fov_deg)
    kept: tuple[tuple[Scene, int, int, float], Renderer] | None = getattr(_LOCAL, "kept", None)
    if kept is None or kept[0] != key:
        _LOCAL.kept = None
        kept = (key, Renderer(scene, width=width, height=height, fov_deg=fov_deg))
        _LOCAL.kept = kept
    return kept[1]


def png(image: UInt8Array) -> bytes:
    """Return (h, w, 3) RGB as a PNG; the same pixels give the same bytes."""
    buffer = io.BytesIO()
    Image.fromarray(image).save(buffer, "PNG", compress_level=6)
    return buffer.getvalue()
