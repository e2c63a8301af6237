"""Pictures of other renderers show the same, and those from elsewhere do not."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from foundry.worlds.camera.eye.likeness import likeness, likeness_of
from foundry.worlds.camera.eye.rendering import png


@pytest.fixture
def picture() -> np.ndarray:
    return np.tile(np.arange(0, 240, 5, dtype=np.uint8)[None, :, None], (40, 1, 3))


def test_rounding_and_a_few_jagged_edges_are_the_same_picture(picture: np.ndarray) -> None:
    other = picture.copy()
    other[::4] += 1
    other[0, :20] ^= 64  # 20 of 1,920 pixels
    found = likeness(picture, other)
    assert found.same and found.far == pytest.approx(20 / 1920)


def test_a_picture_that_is_darker_or_far_off_in_more_than_two_in_a_hundred_pixels_is_another(
    picture: np.ndarray,
) -> None:
    other = picture.copy()
    other[0] ^= 64  # 48 of 1,920 pixels
    assert not likeness(picture, other).same
    assert not likeness(picture + np.uint8(2), picture).same


def test_another_size_and_what_is_no_picture_are_another_picture(picture: np.ndarray) -> None:
    whole, half = png(picture), png(picture[:20])
    assert likeness_of(whole, whole).same
    assert not likeness_of(half, whole).same and not likeness(picture[:20], picture).same
    assert not likeness_of(b"none", whole).same and not likeness_of(whole[:60], whole).same


def test_a_compressed_picture_is_compared_by_what_it_shows(picture: np.ndarray) -> None:
    buffer = io.BytesIO()
    Image.fromarray(picture).save(buffer, "JPEG", quality=95)
    assert likeness_of(png(picture), buffer.getvalue()).far == 0
