"""The view shows what is there, where it is, and the same pixels every time."""

from __future__ import annotations

import hashlib
import io
import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from pxr import Gf, Sdf

from foundry.worlds.camera.eye.rendering import Renderer, png, renderer_for
from foundry.worlds.camera.loading.scene import Scene, SceneMesh
from worlds.camera.usd_files import bind, load, material, mesh, picture, texture_coordinates, textured

EYE = np.array([0.0, 0.0, 2.0])
CENTRE = (48, 64)


def look(scene: Scene, yaw: float = 0.0, pitch: float = 0.0, eye: Any = EYE, fov: float = 60.0) -> Any:
    return renderer_for(scene, width=128, height=96, fov_deg=fov).view(np.asarray(eye, np.float64), yaw, pitch)


def shade(image: Any) -> int:
    """Return the grey at the centre."""
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
    seen = [
        max(pixels, key=pixels.__getitem__)
        for pixels in (
            renderer.visible(EYE, yaw, pitch)
            for yaw, pitch in ((0, 0), (90, 0), (180, 0), (-90, 0), (30, 80), (0, -90))
        )
    ]
    assert [path.split("/")[-1] for path in seen] == ["East", "North", "West", "South", "Ceiling", "Floor"]


def test_the_angle_of_view_is_vertical(tmp_path: Path) -> None:
    half = 2 * np.tan(np.radians(20))
    scene = load(tmp_path, lambda stage: (wall(stage, "/Wall", 2, half), wall(stage, "/Far", 9, 0.1)))
    renderer = renderer_for(scene, width=200, height=100, fov_deg=40.0)
    assert renderer.visible(EYE, 0, 0) == {"/Wall": 100 * 100}


def test_colours_arrive_as_srgb(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        wall(stage, "/Wall", 2, 5, (1, 0.2140, 0))

    red, green, blue = look(load(tmp_path, build))[CENTRE].tolist()
    assert red > 150
    assert (green / red, blue) == (pytest.approx(0.5, abs=0.01), 0)


def test_a_texture_stands_upright_and_unmirrored(tmp_path: Path) -> None:
    four = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]])
    picture(tmp_path / "four.png", four.repeat(8, axis=0).repeat(8, axis=1))

    def build(stage: Any) -> None:
        made = wall(stage, "/Wall", 2, 1)
        texture_coordinates(made, ((0, 0), (1, 0), (1, 1), (0, 1)))
        bind(made, textured(stage, "/Paint", "./four.png"))

    image = look(load(tmp_path, build))
    corners = [image[v, u].astype(int) for v, u in ((27, 43), (27, 84), (68, 43), (68, 84))]
    assert [np.round(corner / corner.max()).tolist() for corner in corners] == [
        [1, 0, 0],
        [0, 1, 0],
        [0, 0, 1],
        [1, 1, 1],
    ]


def test_what_shines_has_its_full_colour(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        black, green = (Sdf.ValueTypeNames.Color3f, Gf.Vec3f(0)), (Sdf.ValueTypeNames.Color3f, Gf.Vec3f(0, 1, 0))
        bind(wall(stage, "/Lamp", 2, 5), material(stage, "/Paint", diffuseColor=black, emissiveColor=green))

    assert look(load(tmp_path, build))[CENTRE].tolist() == [0, 255, 0]


def test_colours_of_points_are_shown(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        colours = wall(stage, "/Wall", 2, 5).CreateDisplayColorPrimvar("vertex")
        colours.Set([Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 0, 1), Gf.Vec3f(0, 0, 1), Gf.Vec3f(1, 0, 0)])

    image = look(load(tmp_path, build)).astype(int)
    assert image[48, 10, 0] > image[48, 117, 0] + 20
    assert image[48, 10, 2] < image[48, 117, 2] - 20


def test_what_is_behind_glass_is_seen_and_counted(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        wall(stage, "/Wall", 3, 9, (1, 0, 0))
        wall(stage, "/Glass", 2, 9, (0, 0, 1)).CreateDisplayOpacityAttr([0.3])

    scene = load(tmp_path, build)
    red, _, blue = look(scene)[CENTRE].tolist()
    assert red > blue > 20
    renderer = renderer_for(scene, width=128, height=96, fov_deg=60.0)
    assert renderer.visible(EYE, 0, 0) == {"/Wall": 128 * 96}


def test_visible_pixels_are_counted_to_the_pixel(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        wall(stage, "/Back", 4, 40)
        wall(stage, "/Front", 2, 0.5)
        wall(stage, "/Hidden", 5, 1)

    scene = load(tmp_path, build)
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


def test_a_pose_seen_again_gives_the_same_bytes(room: Scene) -> None:
    first = png(look(room, 37, -12))
    look(room, 200, 40)
    assert png(look(room, 37, -12)) == first
    assert np.array_equal(np.asarray(Image.open(io.BytesIO(first))), look(room, 37, -12))


@pytest.mark.slow
def test_another_process_gives_the_same_bytes(room: Scene) -> None:
    script = """
import hashlib, sys
from pathlib import Path
import numpy as np
from foundry.worlds.camera.eye.rendering import png, renderer_for
from foundry.worlds.camera.loading.stage import load_scene
renderer = renderer_for(load_scene(Path(sys.argv[1])), width=128, height=96, fov_deg=60.0)
print(hashlib.sha256(png(renderer.view(np.array([0.0, 0.0, 2.0]), 37, -12))).hexdigest())
"""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    command = [sys.executable, "-c", script, room.source]
    out = subprocess.run(command, capture_output=True, text=True, check=True, env=environment).stdout
    assert out.strip() == hashlib.sha256(png(look(room, 37, -12))).hexdigest()


def test_a_renderer_is_made_once_for_a_scene_and_a_size(room: Scene) -> None:
    first = renderer_for(room, width=128, height=96, fov_deg=60.0)
    assert renderer_for(room, width=128, height=96, fov_deg=60.0) is first
    assert renderer_for(room, width=64, height=48, fov_deg=60.0) is not first


def test_another_thread_may_not_use_a_renderer(room: Scene) -> None:
    renderer = renderer_for(room, width=128, height=96, fov_deg=60.0)
    caught: list[str] = []

    def use() -> None:
        try:
            renderer.view(EYE, 0, 0)
        except RuntimeError as error:
            caught.append(str(error))

    thread = threading.Thread(target=use)
    thread.start()
    thread.join()
    assert caught == ["A canvas was used from another thread than the one that made it; it would stay black."]


@pytest.mark.exhaustive
def test_the_memory_of_frames_serves_later_ones(room: Scene) -> None:
    renderer = renderer_for(room, width=512, height=384, fov_deg=70.0)

    def growth_kb() -> int:
        before = held_kb()
        for number in range(200):
            renderer.view(EYE, number, 0)
            renderer.visible(EYE, number, 0)
        return held_kb() - before

    assert any(growth_kb() <= 0 for _ in range(10)), "every two hundred frames take more"


def held_kb() -> int:
    """Return the memory that this process has for itself, wherever the system puts it."""
    status = Path("/proc/self/status")
    text = status.read_text(encoding="utf-8") if status.exists() else ""
    if "RssAnon" not in text:
        pytest.skip("only Linux tells how much memory a process holds now")
    return sum(int(line.split()[1]) for line in text.splitlines() if line.startswith(("RssAnon:", "VmSwap:")))
