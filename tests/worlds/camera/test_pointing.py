"""Where a target is said to be is where its pixels are."""

from itertools import product
from typing import Any

import numpy as np
import pytest
from pxr import Gf

from foundry.records import Pose
from foundry.worlds.camera.eye.rendering import renderer_for
from foundry.worlds.camera.loading.scene import Scene
from foundry.worlds.camera.pointing import Pointed, Pointer
from worlds.camera.conftest import build_room
from worlds.camera.usd_files import loaded, mesh, new_stage

FRAME, FOV_DEG, EYE_M = (160, 120), 70.0, 1.6
RED, GREEN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
SIGN = ("/Room/Sign", (1.9, (-0.9, 0.3), (1.2, 2.4)))
TOP = ("/Room/Top", (1.9, (-0.5, 0.1), (2.2, 2.9)))
LAMP = ("/Room/Lamp", (1.8, (1.2, 1.6), (2.6, 3.0)))
SCREEN = ("/Room/Screen", (0.8, (0.5, 0.9), (0.0, 3.2)))
"""Squares that face west: where, then what they reach from and to along y and z, metres."""
POSES = [
    Pose(x, y, 0.0, yaw, pitch)
    for x, y, yaw, pitch in product((-1.5, 0.2, 1.2), (-1.2, 0.5), range(0, 360, 45), (-40.0, 0.0, 30.0))
]


def square(stage: Any, path: str, place: tuple[float, Any, Any], colour: tuple[float, float, float]) -> None:
    x, (right, left), (low, high) = place
    corners = [(x, right, low), (x, right, high), (x, left, high), (x, left, low)]
    mesh(stage, path, corners).CreateDisplayColorAttr([Gf.Vec3f(*colour)])


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    """A room with a sign of two parts and a lamp in red, and a green screen before some of it."""
    stage = new_stage(tmp_path_factory.mktemp("signs") / "scene.usda")
    build_room(stage)
    for path, place in (SIGN, TOP, LAMP):
        square(stage, path, place, RED)
    square(stage, *SCREEN, GREEN)
    return loaded(stage)


def pointer(scene: Scene, *prims: str) -> Pointer:
    return Pointer(scene, prims, frame=FRAME, fov_deg=FOV_DEG, eye_height=EYE_M)


def red(scene: Scene, pose: Pose) -> Any:
    """Return which pixels, (height, width), of the view are red."""
    renderer = renderer_for(scene, width=FRAME[0], height=FRAME[1], fov_deg=FOV_DEG)
    image = renderer.view(np.array([pose.x, pose.y, EYE_M]), pose.yaw, pose.pitch).astype(int)
    return (image[..., 0] > 60) & (image[..., 0] > 3 * image[..., 1])


def box_of(mask: Any) -> Any:
    rows, columns = np.nonzero(mask)
    return np.array([[columns.min(), rows.min()], [columns.max() + 1, rows.max() + 1]])


def lies_on(mask: Any, pointed: Pointed) -> bool:
    """Return whether the spot that is seen lies on a mask; a pixel beside will do, since edges are mixed colours."""
    assert pointed.spot is not None
    column, row = (pointed.spot * FRAME).astype(int)
    return bool(mask[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2].any())


def test_the_spot_lies_on_the_targets_pixels_and_there_is_none_where_it_is_hidden_or_outside(scene: Scene):
    at, seen, hidden = pointer(scene, "/Room/Sign", "/Room/Top", "/Room/Lamp"), 0, 0
    for pose in POSES:
        mask, pointed = red(scene, pose), at.seen_from(pose)
        if pointed.spot is not None:
            assert lies_on(mask, pointed), pose
            seen += 1
        else:
            assert mask.sum() < 20, pose
            hidden += len(pointed.boxes) > 0
    assert seen > 25 and hidden > 1


def test_boxes_are_drawn_around_the_pixels_one_for_parts_that_overlap_and_one_for_what_is_apart(scene: Scene):
    pose = Pose(-1.5, 0.5, 0.0, 0.0, 5.0)
    boxes = pointer(scene, "/Room/Sign", "/Room/Top", "/Room/Lamp").seen_from(pose).boxes * FRAME
    left, right = sorted(boxes.tolist())
    mask, between = red(scene, pose), round((left[1][0] + right[0][0]) / 2)
    np.testing.assert_allclose(left, box_of(mask & (np.arange(FRAME[0]) < between)), atol=1.2)
    np.testing.assert_allclose(right, box_of(mask & (np.arange(FRAME[0]) >= between)), atol=1.2)


def test_what_is_hidden_has_a_box_where_it_would_be_seen_and_no_spot(scene: Scene):
    pointed = pointer(scene, "/Room/Lamp").seen_from(Pose(-1.5, -1.0, 0.0, 0.0, 5.0))
    assert pointed.spot is None and pointed.centred and len(pointed.boxes) == 1


def test_who_turns_as_told_has_the_middle_of_the_target_in_the_middle_of_the_picture(scene: Scene):
    at, outside = pointer(scene, "/Room/Lamp"), 0
    for pose in POSES:
        pointed = at.seen_from(pose)
        turned = Pose(pose.x, pose.y, pose.z, pose.yaw + pointed.turn, pose.pitch + pointed.tilt)
        (box,) = at.seen_from(turned).boxes
        assert at.seen_from(turned).centred
        np.testing.assert_allclose(box.mean(axis=0), 0.5, atol=0.06)
        outside += not pointed.centred
    assert 0 < outside < len(POSES)
