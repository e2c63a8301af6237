"""Whatever the attributes of a USD file hold, it is drawn as far as it goes, or refused in one line."""

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pxr import Gf, Sdf, UsdShade

from foundry.errors import InputError
from foundry.worlds.camera.eye.rendering import renderer_for
from foundry.worlds.camera.loading.stage import load_scene
from worlds.camera.usd_files import bind, instancer, mesh, picture, shader, texture_coordinates, textured, write_stage

HEAD = """#usda 1.0
(
    upAxis = "Z"
    metersPerUnit = 1
)
"""
SOUND = """def Mesh "Sound"
{
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
}
"""
ODD = """def Mesh "Mesh" {
    float points = 3
}
def Sphere "Sphere" {
    string[] radius = ["x", "y"]
}
def PointInstancer "Copies" {
    string protoIndices = "x"
}
"""
"""Attributes of other types than those that are read."""

NAN, PLACE = float("nan"), [(1, 0, 0)]
_NUMBER = itertools.count()


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("odd")


def test_a_value_of_a_wrong_kind_is_named_and_the_rest_is_drawn(place: Path) -> None:
    (place / "odd.usda").write_text(HEAD + SOUND + ODD)
    scene = load_scene(place / "odd.usda")
    assert "Value of a wrong kind: /Mesh.points; /Sphere.radius; /Copies.protoIndices" in "\n".join(scene.warnings)
    assert [mesh.path for mesh in scene.meshes] == ["/Sound", "/Sphere"]


def nowhere(stage: Any) -> None:
    mesh(stage, "/Sound")
    mesh(stage, "/Nan").AddTranslateOp().Set(Gf.Vec3d(NAN, 0, 0))
    mesh(stage, "/Far").AddScaleOp().Set(Gf.Vec3f(1e30))
    mesh(stage, "/Copies/Tile")
    instancer(stage, "/Copies", ["/Copies/Tile"], [0, 0, 0], [(3, 0, 0), (NAN, 0, 0), (0, 1e30, 0)])


def test_what_is_placed_nowhere_is_left_out_by_name_and_the_rest_is_seen(place: Path) -> None:
    scene = load_scene(write_stage(place / "nowhere.usda", nowhere))
    assert [mesh.path for mesh in scene.meshes] == ["/Sound", "/Copies/Tile"]
    assert scene.bounds.tolist() == [[0, 0, 0], [4, 1, 0]]
    text = "\n".join(scene.warnings)
    assert "Not drawn, since a point is not a number or is beyond 1e+08 m: /Nan; /Far" in text
    assert "Copies without a valid place are not drawn: /Copies[1]; /Copies[2]" in text
    seen = renderer_for(scene, width=64, height=48, fov_deg=60).visible(np.array([0.5, 0.5, 3.0]), 0, -90)
    assert seen["/Sound"] > 100


@pytest.mark.parametrize(("prototype", "inner"), [("/Own", None), ("/Other", "/Own"), ("/Own/Group", None)])
def test_a_point_instancer_within_itself_is_named(place: Path, prototype: str, inner: str | None) -> None:
    def build(stage: Any) -> None:
        mesh(stage, "/Sound")
        instancer(stage, "/Own", [prototype], [0], PLACE)
        mesh(stage, "/Own/Group/Tile")
        instancer(stage, "/Own/Group/Deep", ["/Own"], [0], PLACE)
        if inner:
            instancer(stage, "/Other", [inner], [0], PLACE)

    scene = load_scene(write_stage(place / f"self{next(_NUMBER)}.usda", build))
    assert "/Sound" in [mesh.path for mesh in scene.meshes]
    assert any("contains itself" in line or line.startswith("Prototype not found") for line in scene.warnings)


def test_shader_nodes_in_a_circle_end(place: Path) -> None:
    def build(stage: Any) -> None:
        made = mesh(stage, "/Wall")
        texture_coordinates(made, [(0, 0), (1, 0), (1, 1), (0, 1)])
        bind(made, textured(stage, "/Paint", "./dots.png"))
        turned = shader(stage, "/Paint/Turned", "UsdTransform2d")
        turned.CreateInput("in", Sdf.ValueTypeNames.Float2).ConnectToSource(turned.ConnectableAPI(), "result")
        reader = UsdShade.Shader(stage.GetPrimAtPath("/Paint/Picture"))
        reader.GetInput("st").ConnectToSource(turned.ConnectableAPI(), "result")

    picture(place / "dots.png", [[[0, 0, 255], [255, 0, 0]], [[0, 255, 0], [0, 0, 0]]])
    scene = load_scene(write_stage(place / "circle.usda", build))
    assert [mesh.path for mesh in scene.meshes] == ["/Wall"]


@pytest.mark.parametrize(
    ("line", "said"),
    [(f"metersPerUnit = {unit}", "metersPerUnit") for unit in ("0", "-1", "nan", "inf")] + [('upAxis = "X"', "upAxis")],
)
def test_conventions_that_cannot_be_are_refused(place: Path, line: str, said: str) -> None:
    file = place / f"conventions{next(_NUMBER)}.usda"
    file.write_text(f'#usda 1.0\n(\n{line}\n)\ndef Cube "Cube" {{}}\n')
    with pytest.raises(InputError, match=rf"has {said} = .*Correct the value in the file"):
        load_scene(file)
