"""Draws the overview: the translucent scene from above or the side, with the agent, its path so far and its view."""

import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from PIL import Image, ImageDraw, ImageFont
from scipy.spatial import ConvexHull, QhullError

from foundry.worlds.camera.eye.devices import check_rendering
from foundry.worlds.camera.eye.rendering import Camera, Canvas, direction, in_picture, offsets_from, scene_actors
from foundry.worlds.camera.loading.meshes import Topology, capsule, corner_normals, cylinder, placed, sphere
from foundry.worlds.camera.loading.scene import Colour, FloatArray, Scene, SceneMesh, UInt8Array

RED: Colour = (0.86, 0.08, 0.12)
TRAIL: Colour = (0.95, 0.45, 0.0)
_DARK_RED: Colour = (0.62, 0.04, 0.08)
_SKIN: Colour = (0.93, 0.76, 0.62)
_HAIR: Colour = (0.20, 0.15, 0.12)

_FULL_HEIGHT_M = 1.75


def avatar_meshes(height_m: float) -> list[SceneMesh]:
    """Return the meshes of a person of this height who stands at the origin and looks along +X."""
    parts = [
        _part(sphere(0.13), (0, 0, 1.60), _SKIN),
        _part(sphere(0.135), (-0.03, 0, 1.63), _HAIR),
        _part(cylinder(0.03, 0.0, 0.10, "X"), (0.15, 0, 1.59), _SKIN),
        _part(capsule(0.17, 0.20, 0.38, "Z"), (0, 0, 1.14), RED),
    ]
    for side in (-1, 1):
        parts.append(_part(capsule(0.055, 0.07, 0.46, "Z"), (0.02, side * 0.27, 1.08), RED))
        parts.append(_part(capsule(0.07, 0.095, 0.68, "Z"), (0, side * 0.10, 0.48), _DARK_RED))
        parts.append(_part(capsule(0.06, 0.06, 0.12, "X"), (0.06, side * 0.10, 0.06), _HAIR))
    scale = np.diag([height_m / _FULL_HEIGHT_M] * 3 + [1.0])
    return [placed(part, scale[None]) for part in parts]


def trail_meshes(feet: FloatArray, radius_m: float) -> list[SceneMesh]:
    """Return the meshes of a line through the places (k, 3), metres, with a ball at each place."""
    line = feet + np.array([0.0, 0.0, radius_m])
    if not len(line):
        return []
    shifts = np.tile(np.eye(4), (len(line), 1, 1))
    shifts[:, 3, :3] = line
    balls = [placed(_part(sphere(radius_m * 1.8), (0, 0, 0), TRAIL), shifts)]
    return balls + [_rod(a, b, radius_m) for a, b in zip(line[:-1], line[1:], strict=True) if (a != b).any()]


def _rod(start: FloatArray, end: FloatArray, radius_m: float) -> SceneMesh:
    along = end - start
    length = float(np.linalg.norm(along))
    ahead = along / length
    side = np.cross(ahead, np.eye(3)[int(np.argmin(np.abs(ahead)))])
    side /= np.linalg.norm(side)
    matrix = np.eye(4)
    matrix[:3, :3] = [side, np.cross(ahead, side), ahead]
    matrix[3, :3] = (start + end) / 2
    return placed(_part(cylinder(radius_m, radius_m, length, "Z"), (0, 0, 0), TRAIL), matrix[None])


def _part(shape: Topology, centre: Sequence[float], colour: Colour) -> SceneMesh:
    points = shape.points[shape.triangles].reshape(-1, 3) + np.array(centre)
    return SceneMesh(
        path="/Agent",
        points=points,
        triangles=np.arange(len(points)).reshape(-1, 3),
        normals=corner_normals(shape.points, shape.triangles).reshape(-1, 3),
        colour=colour,
    )


INK, PAPER = (20, 24, 32), (255, 255, 255)
MARGIN_PX, LINE_PX = 12, 24
TEXT_PX, _FRAME_PX = 18, 2
_MOST_LINES = 4


def captioned(image: UInt8Array, text: str) -> UInt8Array:
    """Return the picture (h, w, 3) with a text in a band along the top; a text that is too long is cut."""
    lines = list(_wrapped(text, image.shape[1] - 2 * MARGIN_PX))
    if len(lines) > _MOST_LINES:
        lines = [*lines[: _MOST_LINES - 1], lines[_MOST_LINES - 1] + " …"]
    if not lines:
        return image
    picture = Image.fromarray(image)
    pen = ImageDraw.Draw(picture)
    pen.rectangle((0, 0, picture.width, LINE_PX * len(lines) + MARGIN_PX), fill=PAPER)
    for number, line in enumerate(lines):
        pen.text((MARGIN_PX, MARGIN_PX // 2 + number * LINE_PX), line, fill=INK, font=font())
    return np.asarray(picture, np.uint8)


def inset_size(inset: UInt8Array, width: int) -> tuple[int, int]:
    """Return the width and height in pixels that a picture (h, w, 3) has after it is scaled to this width."""
    return width, round(inset.shape[0] * width / inset.shape[1])


def with_inset(image: UInt8Array, inset: UInt8Array, width: int, place: tuple[int, int]) -> UInt8Array:
    """Return the picture with a second one, scaled to this width and framed, inside it at (left, top)."""
    size = inset_size(inset, width)
    small = Image.fromarray(inset).resize(size, Image.Resampling.LANCZOS)
    picture = Image.fromarray(image)
    left, top = place
    frame = (left - _FRAME_PX, top - _FRAME_PX, left + size[0] + _FRAME_PX - 1, top + size[1] + _FRAME_PX - 1)
    ImageDraw.Draw(picture).rectangle(frame, fill=INK)
    picture.paste(small, (left, top))
    return np.asarray(picture, np.uint8)


@cache
def font() -> ImageFont.FreeTypeFont:
    """Return the font of captions."""
    return ImageFont.truetype(Path(matplotlib.get_data_path()) / "fonts" / "ttf" / "DejaVuSans.ttf", TEXT_PX)


def _wrapped(text: str, width: int) -> Iterator[str]:
    for paragraph in text.splitlines():
        line = ""
        for word in paragraph.split():
            longer = f"{line} {word}".lstrip()
            if line and font().getlength(longer) > width:
                yield line
                longer = word
            line = longer
        yield line


TOP_PX = 40
"""Height of the band at the top for a line of text."""

ZOOMS = tuple(1.0 + 0.05 * number for number in range(30))
"""Factors by which the distance of the large picture's camera is multiplied; they are tried in this order."""

PARTS = (0.0, 0.25, 0.5, 0.75, 1.0)
"""The large picture is shifted by the first of these fractions of the way to the opposite edge that leaves room."""


@dataclass(frozen=True)
class Layout:
    """The places of a large picture and of a small one that covers a part of it.

    Attributes:
        zoom: factor on the distance of the large picture's camera.
        shift: shift of the large picture to the right and down, pixels.
        left, top: upper left corner of the small picture, pixels.
    """

    zoom: float
    shift: tuple[int, int]
    left: int
    top: int


def layout(camera: Camera, bounds: FloatArray, frame: tuple[int, int], inset: tuple[int, int]) -> Layout:
    """Return the layout that changes the large picture least; the small one must not hide the box `bounds` (2, 3).

    `frame` and `inset` are the widths and heights of the large and the small picture, pixels.
    """
    right, bottom = frame[0] - inset[0] - MARGIN_PX, frame[1] - inset[1] - MARGIN_PX
    corners = [(right, bottom), (MARGIN_PX, bottom), (right, TOP_PX + MARGIN_PX), (MARGIN_PX, TOP_PX + MARGIN_PX)]
    for zoom in ZOOMS:
        shown = projected(camera.farther(zoom), bounds, frame)
        for part, (left, top) in product(PARTS, corners):
            shift = _shift(shown, frame, (left == MARGIN_PX, top != bottom), part)
            small = np.array(list(product((left, left + inset[0]), (top, top + inset[1]))))
            if _are_apart(shown + shift, small):
                return Layout(zoom, (round(shift[0]), round(shift[1])), left, top)
    return Layout(1.0, (0, 0), right, bottom)


def projected(camera: Camera, bounds: FloatArray, frame: tuple[int, int]) -> FloatArray:
    """Return the pixels, (8, 2) to the right and down, at which a camera shows the corners of a box (2, 3)."""
    ahead = (camera.target - camera.eye) / np.linalg.norm(camera.target - camera.eye)
    corners = np.array(list(product(*bounds.T)))
    return in_picture(offsets_from(camera.eye, ahead, camera.up, corners), frame, camera.fov_deg)


def shifted(image: UInt8Array, shift: tuple[int, int]) -> UInt8Array:
    """Return a picture (h, w, 3) moved by (right, down) pixels; the empty edge gets the colour of the first pixel."""
    moved = Image.new("RGB", image.shape[1::-1], tuple(image[0, 0].tolist()))
    moved.paste(Image.fromarray(image), shift)
    return np.asarray(moved, np.uint8)


def _shift(shown: FloatArray, frame: tuple[int, int], at: tuple[bool, bool], part: float) -> FloatArray:
    """Return by how many pixels the large picture is shifted away from the small one; `shown` has (n, 2) corners.

    `at` says whether the small picture is at the left, and whether it is at the top.
    """
    low, high = shown.min(axis=0), shown.max(axis=0)
    far = np.array(frame) - MARGIN_PX - high, np.array([MARGIN_PX, TOP_PX + MARGIN_PX]) - low
    return np.asarray(np.round(np.where(at, np.maximum(far[0], 0), np.minimum(far[1], 0)) * part))


def _are_apart(first: FloatArray, second: FloatArray) -> bool:
    """Return whether a strip of width `MARGIN_PX` can separate two sets of points (n, 2)."""
    return any(((second @ axis).min() - (first @ axis).max()) >= MARGIN_PX for axis in _axes(first))


def _axes(points: FloatArray) -> Iterator[FloatArray]:
    yield from np.concatenate([np.eye(2), -np.eye(2)])
    try:
        yield from ConvexHull(points).equations[:, :2]
    except QhullError:  # all on one line
        return


WIDTH, HEIGHT = 960, 720
ABOVE_DEG, ASIDE_DEG = 89.0, 32.0
"""Angle of the camera above the horizon, degrees, for the view from above and for the view from the side."""

_PAPER: Colour = (0.97, 0.97, 0.98)
SCENE_OPACITY = 0.22
LAYERS = 6
_FOV_DEG = 30.0
_TURN_DEG = 22.0
"""Angle between the camera's view and a straight view of the scene's longer side, degrees; it shows depth."""

INSET_WIDTH = 288

_LOCAL = threading.local()


@dataclass(frozen=True, eq=False)
class OverviewFrame:
    """The data from which an overview is drawn: a picture of the scene from outside.

    Attributes:
        foot: (3,) place of the agent's foot, metres.
        trail: (k, 3) earlier places of the agent's foot, the first place first.
        caption: text along the top, such as the step and the command.
        inset: (h, w, 3) the agent's view, or None.
        bounds: (2, 3) box that must be visible, metres; None means the whole scene.
        elevation_deg: elevation of the camera; 90 is straight above.
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
    """Draws overviews of one scene; only the thread that made this object may use it."""

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
        for actor in trail:
            self._canvas.renderer.AddActor(actor)
        image = self._canvas.draw(camera)
        for actor in trail:
            self._canvas.renderer.RemoveActor(actor)
        if frame.inset is not None and placed is not None:
            image = with_inset(shifted(image, placed.shift), frame.inset, INSET_WIDTH, (placed.left, placed.top))
        return captioned(image, frame.caption)

    def _place_avatar(self, frame: OverviewFrame) -> None:
        if frame.height_m != self._height_m:
            for actor in self._avatar:
                self._canvas.renderer.RemoveActor(actor)
            self._height_m, self._avatar = frame.height_m, scene_actors(avatar_meshes(frame.height_m))
            for actor in self._avatar:
                self._canvas.renderer.AddActor(actor)
        for actor in self._avatar:
            actor.SetPosition(*frame.foot)
            actor.SetOrientation(0.0, 0.0, frame.yaw_deg)


def draw_overview(scene: Scene, frame: OverviewFrame) -> UInt8Array:
    """Return the translucent scene with the agent, seen from outside, as (h, w, 3) RGB.

    Each thread caches its latest scene only.
    """
    if getattr(_LOCAL, "scene", None) is not scene:
        check_rendering()
        _LOCAL.scene = _LOCAL.overview = None  # frees the window of the previous scene first
        _LOCAL.overview = Overview(scene)
        _LOCAL.scene = scene
    overview: Overview = _LOCAL.overview
    return overview.draw(frame)


def overview_camera(bounds: FloatArray, elevation_deg: float) -> Camera:
    """Return a camera that looks at the longer side of a box (2, 3) and sees all of the box."""
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
