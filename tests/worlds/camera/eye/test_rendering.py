"""The view shows what is there, where it is, and the same pixels every time; other renderers show the same."""

import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf

from foundry.worlds.camera.eye.likeness import likeness, likeness_of
from foundry.worlds.camera.eye.rendering import Renderer, png, renderer_for
from foundry.worlds.camera.loading.scene import Scene, SceneMesh
from worlds.camera.usd_files import bind, loaded, material, mesh, picture, texture_coordinates, textured

EYE = np.array([0.0, 0.0, 2.0])
CENTRE = (48, 64)


def look(scene: Scene, yaw: float = 0.0, pitch: float = 0.0, eye: Any = EYE, fov: float = 60.0) -> Any:
    return renderer_for(scene, width=128, height=96, fov_deg=fov).view(np.asarray(eye, np.float64), yaw, pitch)


def shade(image: Any) -> int:
    return int(image[CENTRE][0])


def wall(stage: Any, path: str, distance: float, half: float, colour: Any = None) -> Any:
    """Add a square that faces the eye, ahead of it along +X."""
    corners = [(distance, y * half, 2 + z * half) for y, z in ((1, -1), (-1, -1), (-1, 1), (1, 1))]
    made = mesh(stage, path, corners)
    if colour:
        made.CreateDisplayColorAttr([Gf.Vec3f(*colour)])
    return made


def test_the_six_sides_of_a_room_are_told_apart_and_none_is_black_or_blown_out(room: Scene) -> None:
    views = [(0, 0), (90, 0), (180, 0), (270, 0), (0, -89), (0, 89)]
    shades = sorted(shade(look(room, *view)) for view in views)
    grey = 188
    assert shades[0] > 0.55 * grey
    assert shades[-1] <= grey
    assert min(np.diff(shades)) >= 8


def test_yaw_turns_left_and_pitch_looks_up(room: Scene) -> None:
    renderer = renderer_for(room, width=128, height=96, fov_deg=60.0)
    views = ((0, 0), (90, 0), (180, 0), (-90, 0), (30, 80), (0, -90))
    pictures = [renderer.visible(EYE, yaw, pitch) for yaw, pitch in views]
    seen = [max(pixels, key=pixels.__getitem__) for pixels in pictures]
    assert [path.split("/")[-1] for path in seen] == ["East", "North", "West", "South", "Ceiling", "Floor"]


def test_colours_arrive_as_srgb_and_what_shines_has_its_full_colour(stage: Any) -> None:
    wall(stage, "/Wall", 3, 5, (1, 0.2140, 0))
    black, green = (Sdf.ValueTypeNames.Color3f, Gf.Vec3f(0)), (Sdf.ValueTypeNames.Color3f, Gf.Vec3f(0, 1, 0))
    bind(wall(stage, "/Lamp", 2, 0.2), material(stage, "/Paint", diffuseColor=black, emissiveColor=green))
    image = look(loaded(stage))
    red, green, blue = image[10, 10].tolist()
    assert red > 150
    assert (green / red, blue) == (pytest.approx(0.5, abs=0.01), 0)
    assert image[CENTRE].tolist() == [0, 255, 0]


def test_a_texture_stands_upright_and_unmirrored(stage: Any, tmp_path: Path) -> None:
    four = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]])
    picture(tmp_path / "four.png", four.repeat(8, axis=0).repeat(8, axis=1))
    made = wall(stage, "/Wall", 2, 1)
    texture_coordinates(made, ((0, 0), (1, 0), (1, 1), (0, 1)))
    bind(made, textured(stage, "/Paint", "./four.png"))
    image = look(loaded(stage))
    corners = [image[v, u].astype(int) for v, u in ((27, 43), (27, 84), (68, 43), (68, 84))]
    tones = [np.round(corner / corner.max()).tolist() for corner in corners]
    assert tones == [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]]


def test_colours_of_points_are_shown(stage: Any) -> None:
    colours = wall(stage, "/Wall", 2, 5).CreateDisplayColorPrimvar("vertex")
    colours.Set([Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 0, 1), Gf.Vec3f(0, 0, 1), Gf.Vec3f(1, 0, 0)])
    image = look(loaded(stage)).astype(int)
    assert image[48, 10, 0] > image[48, 117, 0] + 20
    assert image[48, 10, 2] < image[48, 117, 2] - 20


def test_what_is_behind_glass_is_seen_and_counted(stage: Any) -> None:
    wall(stage, "/Wall", 3, 9, (1, 0, 0))
    wall(stage, "/Glass", 2, 9, (0, 0, 1)).CreateDisplayOpacityAttr([0.3])
    scene = loaded(stage)
    red, _, blue = look(scene)[CENTRE].tolist()
    assert red > blue > 20
    renderer = renderer_for(scene, width=128, height=96, fov_deg=60.0)
    assert renderer.visible(EYE, 0, 0) == {"/Wall": 128 * 96}


def test_visible_pixels_are_counted_to_the_pixel_in_an_angle_of_view_that_is_vertical(stage: Any) -> None:
    wall(stage, "/Back", 4, 40)
    wall(stage, "/Front", 2, 0.5)
    wall(stage, "/Hidden", 5, 1)
    scene = loaded(stage)
    renderer = renderer_for(scene, width=160, height=100, fov_deg=2 * np.degrees(np.arctan(0.5)))
    assert renderer.visible(EYE, 0, 0) == {"/Back": 160 * 100 - 50 * 50, "/Front": 50 * 50}


def test_hundreds_of_meshes_are_told_apart() -> None:
    meshes = []
    for number in range(700):
        y, z = number % 35, number // 35
        corners = np.array([[0, 0], [0, 1], [1, 1], [1, 0]]) + [y, z]
        points = np.insert(corners.astype(np.float64), 0, 5.0, axis=1)
        triangles = np.array([[0, 1, 2], [0, 2, 3]])
        meshes.append(SceneMesh(path=f"/Tile{number}", points=points, triangles=triangles))
    bounds = np.array([[5.0, 0, 0], [5, 35, 20]])
    scene = Scene("tiles", "", "", tuple(meshes), bounds, {}, (), "Z", 1.0, 700, 1400)
    renderer = Renderer(scene, width=350, height=200, fov_deg=2 * np.degrees(np.arctan(2)))
    assert renderer.visible(np.array([0, 17.5, 10]), 0, 0) == {f"/Tile{number}": 100 for number in range(700)}


def test_a_pose_seen_again_gives_the_same_bytes_by_the_one_renderer_of_a_scene_and_a_size(room: Scene) -> None:
    first = png(look(room, 37, -12))
    look(room, 200, 40)
    assert png(look(room, 37, -12)) == first
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(first))), look(room, 37, -12))
    renderer = renderer_for(room, width=128, height=96, fov_deg=60.0)
    assert renderer_for(room, width=128, height=96, fov_deg=60.0) is renderer
    assert renderer_for(room, width=64, height=48, fov_deg=60.0) is not renderer


@pytest.fixture
def striped() -> np.ndarray:
    return np.tile(np.arange(0, 240, 5, dtype=np.uint8)[None, :, None], (40, 1, 3))


def test_rounding_and_a_few_jagged_edges_are_the_same_picture(striped: np.ndarray) -> None:
    other = striped.copy()
    other[::4] += 1
    other[0, :20] ^= 64  # 20 of 1,920 pixels
    found = likeness(striped, other)
    assert found.same and found.far == pytest.approx(20 / 1920)


def test_a_picture_that_is_darker_or_far_off_in_more_than_two_in_a_hundred_pixels_is_another(
    striped: np.ndarray,
) -> None:
    other = striped.copy()
    other[0] ^= 64  # 48 of 1,920 pixels
    assert not likeness(striped, other).same
    assert not likeness(striped + np.uint8(2), striped).same


def test_another_size_and_what_is_no_picture_are_another_picture(striped: np.ndarray) -> None:
    whole, half = png(striped), png(striped[:20])
    assert likeness_of(whole, whole).same
    assert not likeness_of(half, whole).same and not likeness(striped[:20], striped).same
    assert not likeness_of(b"none", whole).same and not likeness_of(whole[:60], whole).same


def test_a_compressed_picture_is_compared_by_what_it_shows(striped: np.ndarray) -> None:
    buffer = io.BytesIO()
    Image.fromarray(striped).save(buffer, "JPEG", quality=95)
    assert likeness_of(png(striped), buffer.getvalue()).far == 0
