"""Whatever the attributes of a USD file hold, it is drawn as far as it goes, or refused in one line."""

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pxr import Gf, Sdf, UsdGeom, Vt

from foundry.errors import InputError
from foundry.worlds.camera.eye.rendering import renderer_for
from foundry.worlds.camera.loading.scene import Scene
from foundry.worlds.camera.loading.stage import load_scene
from worlds.camera.usd_files import mesh, picture, write_stage

HEAD = """#usda 1.0
(
    upAxis = "Z"
    metersPerUnit = 1
)
"""
AXIS, HEIGHT = 'uniform token axis = "Y"', "double height = 1"
ENDS = ("double radiusTop = 1", "double radiusBottom = 1", HEIGHT, AXIS)
ROUND = ("double radius = 1", HEIGHT, AXIS)
SHAPES = {
    "Sphere": ("double radius = 1",),
    "Cube": ("double size = 1",),
    "Cylinder": ROUND,
    "Cylinder_1": ENDS,
    "Cone": ROUND,
    "Capsule": ROUND,
    "Capsule_1": ENDS,
    "Plane": ("double width = 1", "double length = 1", AXIS),
}
ALL = (
    HEAD
    + """
def Mesh "Sound"
{
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
}
def Mesh "Mesh" (prepend apiSchemas = ["MaterialBindingAPI", "SemanticsLabelsAPI:class", "GeomModelAPI"])
{
    rel material:binding = </Paint>
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    int[] faceVertexCounts = [4, 3, 3]
    int[] faceVertexIndices = [0, 1, 2, 3, 0, 1, 2, 0, 2, 3]
    int[] holeIndices = [2]
    normal3f[] normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)]
    uniform token orientation = "leftHanded"
    uniform bool doubleSided = 1
    token visibility = "inherited"
    uniform token purpose = "default"
    uniform token model:drawMode = "default"
    token[] semantics:labels:class = ["square"]
    string semantic:one:params:semanticData = "square"
    texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "vertex")
    int[] primvars:st:indices = [0, 1, 2, 3]
    color3f[] primvars:displayColor = [(1, 0, 0)]
    float[] primvars:displayOpacity = [0.5]
    normal3f[] primvars:normals = [(0, 0, 1)] (interpolation = "constant")
    double3 xformOp:translate = (0, 0, 1)
    float3 xformOp:scale = (1, 1, 1)
    float xformOp:rotateZ = 3
    matrix4d xformOp:transform = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:scale", "xformOp:rotateZ", "xformOp:transform"]
    def GeomSubset "Part" (prepend apiSchemas = ["MaterialBindingAPI"])
    {
        rel material:binding = </Omni>
        uniform token elementType = "face"
        uniform token familyName = "materialBind"
        int[] indices = [0]
    }
}
def PointInstancer "Copies"
{
    rel prototypes = [</Copies/Thing>]
    int[] protoIndices = [0, 0]
    point3f[] positions = [(0, 0, 0), (1, 0, 0)]
    quath[] orientations = [(1, 0, 0, 0), (1, 0, 0, 0)]
    float3[] scales = [(1, 1, 1), (2, 2, 2)]
    int64[] ids = [1, 2]
    int64[] invisibleIds = [2]
    def Cube "Thing" {}
}
def Material "Paint"
{
    token outputs:surface.connect = </Paint/Surface.outputs:surface>
    def Shader "Surface"
    {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </Paint/Picture.outputs:rgb>
        color3f inputs:emissiveColor = (0, 0, 0.1)
        float inputs:opacity = 0.9
        float inputs:opacityThreshold = 0.1
        token outputs:surface
    }
    def Shader "Picture"
    {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @./dots.png@
        float2 inputs:st.connect = </Paint/Turn.outputs:result>
        float4 inputs:scale = (1, 1, 1, 1)
        float4 inputs:bias = (0, 0, 0, 0)
        float4 inputs:fallback = (0, 1, 0, 1)
        token inputs:wrapS = "repeat"
        token inputs:sourceColorSpace = "raw"
        float3 outputs:rgb
    }
    def Shader "Turn"
    {
        uniform token info:id = "UsdTransform2d"
        float2 inputs:in.connect = </Paint/St.outputs:result>
        float2 inputs:scale = (1, 1)
        float2 inputs:translation = (0, 0)
        float inputs:rotation = 0
        float2 outputs:result
    }
    def Shader "St"
    {
        uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "st"
        float2 outputs:result
    }
}
def Material "Omni"
{
    token outputs:mdl:surface.connect = </Omni/Surface.outputs:out>
    def Shader "Surface"
    {
        uniform token info:implementationSource = "sourceAsset"
        uniform asset info:mdl:sourceAsset = @OmniPBR.mdl@
        uniform token info:mdl:sourceAsset:subIdentifier = "OmniPBR"
        color3f inputs:diffuse_color_constant = (1, 1, 0)
        color3f inputs:diffuse_tint = (1, 1, 0.5)
        asset inputs:diffuse_texture = @./dots.png@
        bool inputs:project_uvw = 1
        float2 inputs:texture_scale = (1, 1)
        float2 inputs:texture_translate = (1, 1)
        float inputs:texture_rotate = 1
        bool inputs:enable_opacity = 1
        asset inputs:opacity_texture = @./dots.png@
        float inputs:opacity_constant = 1
        bool inputs:enable_emission = 1
        color3f inputs:emissive_color = (0, 1, 0)
        token outputs:out
    }
}
"""
    + "".join(
        f'def {kind} "{kind}"\n{{\n' + "".join(f"    {line}\n" for line in lines) + "}\n"
        for kind, lines in SHAPES.items()
    )
)
"""A stage in which every attribute that is read holds something."""

NAMES, NAN, INF = Sdf.ValueTypeNames, float("nan"), float("inf")
ODD: dict[str, tuple[Any, Any]] = {
    "nothing": (NAMES.Float, None),
    "a number": (NAMES.Float, 3.0),
    "NaN": (NAMES.Double, NAN),
    "a huge number": (NAMES.Double, 1e300),
    "a negative number": (NAMES.Int, -7),
    "a text": (NAMES.String, "x"),
    "texts": (NAMES.StringArray, Vt.StringArray(["x", "y", "z"])),
    "no texts": (NAMES.TokenArray, Vt.TokenArray()),
    "a file": (NAMES.Asset, Sdf.AssetPath("x.png")),
    "numbers": (NAMES.FloatArray, Vt.FloatArray([0.0, NAN, INF, -1e30, 5.5])),
    "whole numbers": (NAMES.Int64Array, Vt.Int64Array([-(2**60), 2**60, 1, 0])),
    "no numbers": (NAMES.IntArray, Vt.IntArray()),
    "vectors": (NAMES.Float3Array, Vt.Vec3fArray([Gf.Vec3f(0, NAN, INF), Gf.Vec3f(1e30), Gf.Vec3f(0)])),
    "pairs": (NAMES.Float2Array, Vt.Vec2fArray([Gf.Vec2f(0), Gf.Vec2f(1)])),
    "a vector": (NAMES.Float3, Gf.Vec3f(NAN, 1, INF)),
    "a matrix": (NAMES.Matrix4d, Gf.Matrix4d(1e200, NAN, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1e30, 0, 0, 1)),
    "truth values": (NAMES.BoolArray, Vt.BoolArray([True, False])),
    "turns": (NAMES.QuathArray, Vt.QuathArray(2)),
}


def attributes() -> list[str]:
    layer, texts = Sdf.Layer.CreateAnonymous(".usda"), []
    layer.ImportFromString(ALL)
    layer.Traverse("/", lambda path: texts.append(str(path)) if path.IsPropertyPath() else None)
    return sorted(path for path in texts if isinstance(layer.GetObjectAtPath(path), Sdf.AttributeSpec))


ATTRIBUTES = attributes()


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("odd")
    picture(folder / "dots.png", [[[0, 0, 255], [255, 0, 0]], [[0, 255, 0], [0, 0, 0]]])
    return folder


_NUMBER = itertools.count()


def loaded(place: Path, odd: dict[str, str]) -> Scene | str:
    """Load the stage with some attributes of other types and values; returns it, or the line that refuses it."""
    layer = Sdf.Layer.CreateAnonymous(".usda")
    layer.ImportFromString(ALL)
    for path, kind in odd.items():
        where = Sdf.Path(path)
        prim = layer.GetPrimAtPath(where.GetPrimPath())
        prim.RemoveProperty(prim.properties[where.name])
        value_type, value = ODD[kind]
        made = Sdf.AttributeSpec(prim, where.name, value_type)
        if value is not None:
            made.default = value
    file = place / f"scene{next(_NUMBER)}.usda"
    layer.Export(str(file))
    try:
        return load_scene(file)
    except InputError as error:
        return str(error)


def check(result: Scene | str, odd: dict[str, str]) -> None:
    if isinstance(result, str):
        assert "\n" not in result, odd
        return
    assert any(part.path == "/Sound" for part in result.meshes) or any("/Sound" in path for path in odd), odd
    assert np.isfinite(result.bounds).all(), odd
    for part in result.meshes:
        for numbers in (part.points, part.normals, part.uvs, part.colour, part.emissive, part.opacity):
            assert numbers is None or np.isfinite(numbers).all(), (part.path, odd)
        assert 0 <= part.opacity <= 1 and part.triangles.max() < len(part.points), (part.path, odd)


def test_the_stage_without_anything_odd_is_drawn_whole(place: Path) -> None:
    scene = loaded(place, {})
    assert isinstance(scene, Scene)
    assert not [line for line in scene.warnings if "wrong kind" in line or "nowhere" in line]
    assert all(mesh.texture is not None for mesh in scene.meshes if mesh.path.startswith("/Mesh"))
    drawn = {f"/{kind}" for kind in SHAPES} | {"/Sound", "/Mesh", "/Mesh/Part", "/Copies/Thing"}
    assert {mesh.path for mesh in scene.meshes} == drawn


def test_a_value_of_a_wrong_kind_is_named_and_the_rest_is_drawn(place: Path) -> None:
    scene = loaded(place, {"/Mesh.points": "a number", "/Sphere.radius": "texts", "/Copies.protoIndices": "a text"})
    assert isinstance(scene, Scene)
    assert "Value of a wrong kind: /Mesh.points; /Copies.protoIndices; /Sphere.radius" in "\n".join(scene.warnings)
    assert {"/Sound", "/Sphere"} <= {mesh.path for mesh in scene.meshes}


def nowhere(stage: Any) -> None:
    mesh(stage, "/Sound")
    mesh(stage, "/Nan").AddTranslateOp().Set(Gf.Vec3d(NAN, 0, 0))
    mesh(stage, "/Far").AddScaleOp().Set(Gf.Vec3f(1e30))
    copies = UsdGeom.PointInstancer.Define(stage, "/Copies")
    copies.CreatePrototypesRel().SetTargets([mesh(stage, "/Copies/Tile").GetPath()])
    copies.CreateProtoIndicesAttr([0, 0, 0])
    copies.CreatePositionsAttr([Gf.Vec3f(3, 0, 0), Gf.Vec3f(NAN, 0, 0), Gf.Vec3f(0, 1e30, 0)])


def test_what_is_placed_nowhere_is_left_out_by_name_and_the_rest_is_seen(place: Path) -> None:
    scene = load_scene(write_stage(place / "nowhere.usda", nowhere))
    assert [mesh.path for mesh in scene.meshes] == ["/Sound", "/Copies/Tile"]
    assert scene.bounds.tolist() == [[0, 0, 0], [4, 1, 0]]
    text = "\n".join(scene.warnings)
    assert "Not drawn, since a point is not a number or is beyond 1e+08 m: /Nan; /Far" in text
    assert "Copies without a valid place are not drawn: /Copies[1]; /Copies[2]" in text
    seen = renderer_for(scene, width=64, height=48, fov_deg=60).visible(np.array([0.5, 0.5, 3.0]), 0, -90)
    assert seen["/Sound"] > 100


def instancer(stage: Any, path: str, prototype: str) -> None:
    made = UsdGeom.PointInstancer.Define(stage, path)
    made.CreatePrototypesRel().SetTargets([Sdf.Path(prototype)])
    made.CreateProtoIndicesAttr([0])
    made.CreatePositionsAttr([Gf.Vec3f(1, 0, 0)])


@pytest.mark.parametrize(("prototype", "inner"), [("/Own", None), ("/Other", "/Own"), ("/Own/Group", None)])
def test_a_point_instancer_within_itself_is_named(place: Path, prototype: str, inner: str | None) -> None:
    def build(stage: Any) -> None:
        mesh(stage, "/Sound")
        instancer(stage, "/Own", prototype)
        mesh(stage, "/Own/Group/Tile")
        instancer(stage, "/Own/Group/Deep", "/Own")
        if inner:
            instancer(stage, "/Other", inner)

    scene = load_scene(write_stage(place / f"self{next(_NUMBER)}.usda", build))
    assert "/Sound" in [mesh.path for mesh in scene.meshes]
    assert any("contains itself" in line or line.startswith("Prototype not found") for line in scene.warnings)


def test_shader_nodes_in_a_circle_end(place: Path) -> None:
    file = place / "circle.usda"
    file.write_text(ALL.replace("inputs:in.connect = </Paint/St", "inputs:in.connect = </Paint/Turn"))
    assert any(mesh.path == "/Mesh/Part" for mesh in load_scene(file).meshes)


@pytest.mark.parametrize(
    ("line", "said"),
    [(f"metersPerUnit = {unit}", "metersPerUnit") for unit in ("0", "-1", "nan", "inf")] + [('upAxis = "X"', "upAxis")],
)
def test_conventions_that_cannot_be_are_refused(place: Path, line: str, said: str) -> None:
    file = place / f"conventions{next(_NUMBER)}.usda"
    file.write_text(f'#usda 1.0\n(\n{line}\n)\ndef Cube "Cube" {{}}\n')
    with pytest.raises(InputError, match=rf"has {said} = .*Correct the value in the file"):
        load_scene(file)


@pytest.mark.slow
@given(st.dictionaries(st.sampled_from(ATTRIBUTES), st.sampled_from(sorted(ODD)), min_size=1, max_size=4))
@settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_attributes_of_any_kind_end_in_no_traceback(place: Path, odd: dict[str, str]) -> None:
    check(loaded(place, odd), odd)
