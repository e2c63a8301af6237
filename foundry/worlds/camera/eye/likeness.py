"""Whether two pictures show the same: renderers differ in rounding and on edges, and in nothing else."""

from __future__ import annotations

import io
from dataclasses import dataclass

import numpy as np
from PIL import Image

from foundry.worlds.camera.loading.scene import UInt8Array

MEAN_AT_MOST, FAR_AT_MOST = 1.0, 0.02
"""Tolerance: mean difference of 255, and the share of pixels that are far off.

Mesa's two software renderers, one with and one without smooth edges, differ by up to 0.65 and 0.015 in the shipped
scenes; the same scenes from an eye turned by one degree by 2.7 and 0.04 at the least.
"""
FAR = 16
"""Difference of a channel from which a pixel is far off, of 255."""


@dataclass(frozen=True)
class Likeness:
    """How far two pictures are apart.

    Attributes:
        mean: mean absolute difference of the channels, of 255.
        far: share of pixels with a channel that is far off.
    """

    mean: float
    far: float

    @property
    def same(self) -> bool:
        """Whether they are within the tolerance."""
        return self.mean <= MEAN_AT_MOST and self.far <= FAR_AT_MOST


_NOTHING_ALIKE = Likeness(255.0, 1.0)


def likeness(one: UInt8Array, other: UInt8Array) -> Likeness:
    """Return how far two pictures (h, w, 3) are apart; as far as can be where their sizes differ."""
    if one.shape != other.shape:
        return _NOTHING_ALIKE
    apart = np.abs(one.astype(np.int16) - other)
    return Likeness(float(apart.mean()), float((apart.max(axis=2) > FAR).mean()))


def likeness_of(recorded: bytes, now: bytes) -> Likeness:
    """Return how far two encoded pictures are apart; as far as can be where the recorded one is damaged."""
    fresh = Image.open(io.BytesIO(now))
    try:
        then = Image.open(io.BytesIO(recorded))
        if then.size != fresh.size:  # what a damaged head says may fill the memory
            return _NOTHING_ALIKE
        return likeness(_rgb(then), _rgb(fresh))
    except (OSError, ValueError, SyntaxError):
        return _NOTHING_ALIKE


def _rgb(picture: Image.Image) -> UInt8Array:
    return np.asarray(picture.convert("RGB"), np.uint8)
