"""A run's scene as GLB is the scene that foundry draws."""

import io
import json
import shutil
import struct
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from commands import succeeds
from episodes import composed
from foundry.errors import InputError
from foundry.paths import assets_dir
from foundry.storing.store import RunFolder, SweepFolder
from foundry.viewer.camera.camera_view import CameraView
from foundry.viewer.camera.scene_export import LARGEST_PX, kept_scene_glb, scene_glb
from foundry.worlds.camera.loading.scene import Scene
from foundry.worlds.camera.loading.stage import load_scene

KINDS = {5126: "<f4", 5125: "<u4", 5121: "u1"}
CHANGED = ("world.camera.fov=50", "world.scene.exclude=[/World/Racks]")
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class Glb:
    def __init__(self, content: bytes) -> None:
        magic, version, length = struct.unpack_from("<4sII", content)
        assert (magic, version, length) == (b"glTF", 2, len(content))
        size, kind = struct.unpack_from("<I4s", content, 12)
        assert kind == b"JSON" and size % 4 == 0
        self.head: dict[str, Any] = json.loads(content[20 : 20 + size])
        rest, kind = struct.unpack_from("<I4s", content, 20 + size)
        assert kind == b"BIN\0" and rest == self.head["buffers"][0]["byteLength"]
        self.content = content[28 + size :]
        assert len(self.content) == rest

    def view(self, number: int) -> bytes:
        part = self.head["bufferViews"][number]
        assert part["byteOffset"] % 4 == 0
        return self.content[part["byteOffset"] : part["byteOffset"] + part["byteLength"]]

    def values(self, number: int) -> Any:
        part = self.head["accessors"][number]
        values = np.frombuffer(self.view(part["bufferView"]), KINDS[part["componentType"]])
        return values.reshape(part["count"], WIDTHS[part["type"]])

    def primitives(self) -> list[Mapping[str, Any]]:
        return [primitive for mesh in self.head["meshes"] for primitive in mesh["primitives"]]


def config(world: str, *overrides: str) -> Mapping[str, Any]:
    return composed(world, "stay", *overrides).conditions[0].config


@lru_cache
def exported(world: str, *overrides: str) -> tuple[Glb, Scene]:
    content = scene_glb(config(world, *overrides))
    assert content is not None and len(content) < 500_000
    return Glb(content), load_scene(assets_dir() / f"{world}.usdz")


@pytest.mark.slow
@pytest.mark.parametrize("world", ["kibo", pytest.param("gallery", marks=pytest.mark.exhaustive)])
def test_every_triangle_is_there_where_it_is_in_a_small_file(world: str):
    glb, scene = exported(world)
    points = [glb.values(part["attributes"]["POSITION"]) for part in glb.primitives()]
    corners = [at[glb.values(part["indices"])[:, 0]] for at, part in zip(points, glb.primitives(), strict=True)]
    assert sum(map(len, corners)) == 3 * scene.triangles
    joined = np.concatenate(corners).reshape(-1, 3, 3)
    np.testing.assert_allclose([joined.min(axis=(0, 1)), joined.max(axis=(0, 1))], scene.bounds, atol=1e-5)
    assert area(joined) == pytest.approx(sum(area(mesh.points[mesh.triangles]) for mesh in scene.meshes), rel=1e-5)


def area(triangles: Any) -> float:
    sides = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return float(np.linalg.norm(sides, axis=1).sum() / 2)


@pytest.mark.slow
def test_textures_are_readable_no_larger_than_needed_and_used_by_unlit_materials():
    glb, scene = exported("kibo")
    for image in glb.head["images"]:
        with Image.open(io.BytesIO(glb.view(image["bufferView"]))) as picture:
            assert Image.MIME[picture.format or ""] == image["mimeType"]
            assert max(picture.size) <= LARGEST_PX
    shown = {id(mesh.texture) for mesh in scene.meshes if mesh.texture is not None}
    assert len(glb.head["textures"]) >= len(shown) > 0
    assert all("KHR_materials_unlit" in one["extensions"] for one in glb.head["materials"])
    textured = [part for part in glb.primitives() if "TEXCOORD_0" in part["attributes"]]
    looks = [glb.head["materials"][part["material"]]["pbrMetallicRoughness"] for part in textured]
    assert all("baseColorTexture" in look for look in looks)


def test_the_eye_and_the_targets_come_with_the_scene():
    glb, scene = exported("kibo", *CHANGED)
    (camera,) = glb.head["cameras"]
    assert np.degrees(camera["perspective"]["yfov"]) == pytest.approx(50)
    assert camera["perspective"]["aspectRatio"] == pytest.approx(512 / 384)
    eye = next(node for node in glb.head["nodes"] if "camera" in node)
    assert (eye["translation"], eye["extras"]) == ([0, 0, 1.6], {"body_height": 1.75})
    targets = glb.head["nodes"][glb.head["scenes"][0]["nodes"][0]]["extras"]["targets"]
    labelled = [mesh for mesh in scene.meshes if mesh.path.startswith("/World/Emblem")]
    assert set(targets) == {mesh.path for mesh in labelled} != set()
    assert targets[labelled[0].path][0] == labelled[0].points.min(axis=0).tolist()


def test_what_is_excluded_and_a_2d_world_are_not_exported():
    glb, scene = exported("kibo", *CHANGED)
    triangles = sum(len(glb.values(part["indices"])) // 3 for part in glb.primitives())
    assert 0 < triangles < scene.triangles
    assert scene_glb(config("cafe_library")) is None


def test_the_same_scene_gives_the_same_bytes():
    content = scene_glb(config("kibo", *CHANGED))
    assert content is not None and Glb(content).content == exported("kibo", *CHANGED)[0].content


@pytest.fixture
def own_scene(workspace: Path) -> RunFolder:
    shutil.copy(assets_dir() / "gallery.usdz", "rooms.usdz")
    overrides = ("world=usd", "scene=rooms.usdz", "task=Look", "world.steps=1")
    settings = ("model=scripted/stay", "output.dir=out", "analyze=false", "runner.workers=1")
    succeeds(*overrides, *settings, cwd=workspace)
    (run,) = SweepFolder.open("out").runs()
    return run


@pytest.mark.slow
def test_an_analysed_sweep_keeps_scene_and_plan_of_its_runs_and_needs_the_file_no_more(own_scene: RunFolder):
    shutil.copy(assets_dir() / "office.usdz", "rooms.usdz")
    with pytest.raises(InputError, match="is not the scene of the run"):
        kept_scene_glb(own_scene)
    shutil.copy(assets_dir() / "gallery.usdz", "rooms.usdz")
    succeeds("analyze", "out", cwd=Path.cwd())
    Path("rooms.usdz").unlink()
    assert kept_scene_glb(own_scene) is not None
    assert json.loads(CameraView(own_scene).plan().content)["walls"]
    (own_scene.path / "episode.jsonl").unlink()
    assert kept_scene_glb(own_scene) is None  # not begun
