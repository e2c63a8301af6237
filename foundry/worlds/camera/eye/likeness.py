"""Compares pictures with a tolerance, since two renderers differ in rounding and at edges."""

import io
from dataclasses import dataclass

import numpy as np
from PIL import Image

from foundry.worlds.camera.loading.scene import UInt8Array

MEAN_AT_MOST, FAR_AT_MOST = 1.0, 0.02
"""Largest differences of equal pictures: mean difference out of 255, and share of pixels with a large difference.

In the shipped scenes, pictures of Mesa's two software renderers, with and without smooth edges, have a mean difference
of at most 0.65, and a large difference in at most 0.015 of the pixels. Two pictures whose views are one degree apart
have a mean difference of at least 2.7, and a large difference in at least 0.04 of the pixels.
"""
FAR = 16
"""A channel's difference above this value counts as large, out of 255."""


@dataclass(frozen=True)
class Likeness:
    """Measures of the difference between two pictures.

    Attributes:
        mean: mean absolute difference of their channels, out of 255.
        far: share of pixels with a large difference in any channel.
    """

    mean: float
    far: float

    @property
    def same(self) -> bool:
        """True if the difference is within the tolerance."""
        return self.mean <= MEAN_AT_MOST and self.far <= FAR_AT_MOST


_NOTHING_ALIKE = Likeness(255.0, 1.0)


def likeness(first: UInt8Array, other: UInt8Array) -> Likeness:
    """Return the difference of two pictures (h, w, 3), the largest possible one if their sizes differ."""
    if first.shape != other.shape:
        return _NOTHING_ALIKE
    apart = np.abs(first.astype(np.int16) - other)
    return Likeness(float(apart.mean()), float((apart.max(axis=2) > FAR).mean()))


def likeness_of(recorded: bytes, now: bytes) -> Likeness:
    """Return the difference of two encoded pictures; the largest possible one if the recorded picture is damaged."""
    fresh = Image.open(io.BytesIO(now))
    try:
        then = Image.open(io.BytesIO(recorded))
        if then.size != fresh.size:  # a damaged header may ask for more than the memory
            return _NOTHING_ALIKE
        return likeness(_rgb(then), _rgb(fresh))
    except (OSError, ValueError, SyntaxError):
        return _NOTHING_ALIKE


def _rgb(picture: Image.Image) -> UInt8Array:
    return np.asarray(picture.convert("RGB"), np.uint8)
