"""Where a small picture goes in a large one, so that it hides nothing of what the large one shows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from foundry.worlds.camera.eye.canvas import Camera
from foundry.worlds.camera.eye.directions import in_picture, offsets_from
from foundry.worlds.camera.loading.scene import FloatArray, UInt8Array

MARGIN_PX = 12
"""Room around the small picture, and between the large one's edge and what it shows."""

TOP_PX = 40
"""Room along the top for a line of text."""

ZOOMS = tuple(1.0 + 0.05 * number for number in range(30))
"""How much farther off the large picture may be taken from."""

PARTS = (0.0, 0.25, 0.5, 0.75, 1.0)
"""How much of the way to the opposite edges the large picture may be moved."""


@dataclass(frozen=True)
class Layout:
    """How two pictures share a frame.

    Attributes:
        zoom: how many times farther off the large picture is taken from.
        shift: pixels by which it is moved to the right and down.
        left, top: where the small picture begins, pixels.
    """

    zoom: float
    shift: tuple[int, int]
    left: int
    top: int


def layout(camera: Camera, bounds: FloatArray, frame: tuple[int, int], inset: tuple[int, int]) -> Layout:
    """Return the layout that changes the large picture least; frame and inset are (width, height) in pixels.

    Args:
        camera: takes the large picture.
        bounds: (2, 3) box of what it shows, metres.
        frame: size of the large picture.
        inset: size of the small one.
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
    """Return the (8, 2) pixels, to the right and down, at which the corners of a box (2, 3) are drawn."""
    ahead = (camera.target - camera.eye) / np.linalg.norm(camera.target - camera.eye)
    corners = np.array(list(product(*bounds.T)))
    return in_picture(offsets_from(camera.eye, ahead, camera.up, corners), frame, camera.fov_deg)


def shifted(image: UInt8Array, shift: tuple[int, int]) -> UInt8Array:
    """Return an (h, w, 3) picture moved by (right, down) pixels; what comes in is of the colour of its first pixel."""
    height, width = image.shape[:2]
    moved = np.empty_like(image)
    moved[:] = image[0, 0]
    x, y = shift
    moved[max(y, 0) : height + min(y, 0), max(x, 0) : width + min(x, 0)] = image[
        max(-y, 0) : height - max(y, 0), max(-x, 0) : width - max(x, 0)
    ]
    return moved


def _shift(shown: FloatArray, frame: tuple[int, int], at: tuple[bool, bool], part: float) -> FloatArray:
    """Return the pixels to move by, away from an inset; `at`: whether it is at the left, and at the top."""
    low, high = shown.min(axis=0), shown.max(axis=0)
    far = np.array(frame) - MARGIN_PX - high, np.array([MARGIN_PX, TOP_PX + MARGIN_PX]) - low
    return np.asarray(np.round(np.where(at, np.maximum(far[0], 0), np.minimum(far[1], 0)) * part))


def _are_apart(first: FloatArray, second: FloatArray) -> bool:
    """Return whether the hulls of two sets of (n, 2) points are apart by a margin: some straight line lies between."""
    return any(((second @ axis).min() - (first @ axis).max()) >= MARGIN_PX for axis in _axes(first))


def _axes(points: FloatArray) -> Iterator[FloatArray]:
    yield from np.concatenate([np.eye(2), -np.eye(2)])
    try:
        yield from ConvexHull(points).equations[:, :2]
    except QhullError:  # all on one line
        return
