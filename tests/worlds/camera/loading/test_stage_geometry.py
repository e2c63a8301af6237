"""What a stage composes comes out as triangles: faces, normals, colours, shapes, references, copies, labels."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pxr import Gf, Sdf, Usd, UsdGeom, UsdSemantics, Vt

from foundry.errors import InputError
from foundry.worlds.camera.loading.meshes import triangulated
from foundry.worlds.camera.loading.scene import Scene
from foundry.worlds.camera.loading.stage import load_scene
from worlds.camera.usd_files import instancer, loaded, mesh, new_stage, one_mesh, primvar, write_stage

NAMES = Sdf.ValueTypeNames
UP = [0, 0, 1]


def facing(scene: Scene) -> list[list[float]]:
    """Return the direction that the first triangle of each mesh faces by its winding, rounded."""
    directions = []
    for scene_mesh in scene.meshes:
        a, b, c = scene_mesh.points[scene_mesh.triangles[0]]
        normal = np.cross(b - a, c - a)
        directions.append((np.round(normal / np.linalg.norm(normal), 3) + 0.0).tolist())
    return directions


def area(scene: Scene) -> float:
    total = 0.0
    for scene_mesh in scene.meshes:
        a, b, c = (scene_mesh.points[scene_mesh.triangles[:, corner]] for corner in range(3))
        total += float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2
    return total


def paths(scene: Scene) -> list[str]:
    return [mesh.path for mesh in scene.meshes]


def test_a_square_becomes_two_triangles_that_face_up_in_the_colour_of_srgb(stage: Any) -> None:
    mesh(stage, "/Floor").CreateDisplayColorAttr([Gf.Vec3f(0.2140, 0, 1)])
    scene = loaded(stage)
    found = one_mesh(scene)
    assert (found.path, scene.triangles, len(found.points)) == ("/Floor", 2, 4)
    assert scene.bounds.tolist() == [[0, 0, 0], [1, 1, 0]]
    assert facing(scene) == [UP] and found.normals.tolist() == [UP] * 4
    assert found.colour == pytest.approx((0.5, 0, 1), abs=1e-3)
    assert found.vertex_colours is None and scene.warnings == ()


def test_conventions_of_a_file_become_z_up_and_metres_and_those_of_usd_are_taken_with_a_warning(tmp_path: Path) -> None:
    stage = new_stage(tmp_path / "wall.usda", up="Y", unit=0.01)
    mesh(stage, "/Wall", ((100, 0, -30), (200, 0, -30), (200, 50, -30)), [(0, 1, 2)])
    scene = loaded(stage)
    assert np.allclose(scene.bounds, [[1, 0.3, 0], [2, 0.3, 0.5]])
    assert (scene.up_axis, scene.metres_per_unit) == ("Y", 0.01)
    assert facing(scene) == [[0, -1, 0]]
    stage = new_stage(tmp_path / "floor.usda", up=None, unit=None)
    mesh(stage, "/Floor")
    scene = loaded(stage)
    assert (scene.up_axis, scene.metres_per_unit) == ("Y", 0.01)
    assert [line.split(":")[0] for line in scene.warnings] == ["No upAxis in the file", "No metersPerUnit in the file"]


def test_concave_faces_keep_their_area_and_holes_have_none(stage: Any) -> None:
    dart = [(0, 0, 0), (2, 0, 0), (0.5, 0.5, 0), (0, 2, 0)]
    ell = [(0, 0, 1), (3, 0, 1), (3, 1, 1), (1, 1, 1), (1, 3, 1), (0, 3, 1)]
    cup = [(0, 0, 2), (4, 0, 2), (4, 3, 2), (3, 3, 2), (3, 1, 2), (1, 1, 2), (1, 3, 2), (0, 3, 2)]
    strip = [(x, y, 3) for y in range(2) for x in range(3)]
    faces = [range(4), range(4, 10), range(10, 18), (18, 19, 22, 21), (19, 20, 23, 22), (18, 19)]
    mesh(stage, "/Shapes", [*dart, *ell, *cup, *strip], faces, holeIndices=[4])
    scene = loaded(stage)
    assert scene.triangles == 2 + 4 + 6 + 2
    assert area(scene) == pytest.approx(1 + 5 + 8 + 1)


@given(st.integers(3, 12).flatmap(lambda n: st.lists(st.floats(0.2, 3), min_size=n, max_size=n)))
def test_any_star_shaped_face_is_cut_without_gap_or_overlap(radii: list[float]) -> None:
    angles = np.arange(len(radii)) * (2 * np.pi / len(radii))
    points = np.stack([np.cos(angles), np.sin(angles), np.zeros(len(radii))], axis=1) * np.array(radii)[:, None]
    empty = np.zeros(0, np.int64)
    cut = triangulated(points, np.array([len(radii)]), np.arange(len(radii)), empty)
    a, b, c = (points[cut.triangles[:, corner]] for corner in range(3))
    signed = np.cross(b - a, c - a)[:, 2] / 2
    x, y = points[:, 0], points[:, 1]
    assert len(cut.triangles) == len(radii) - 2
    assert np.abs(signed).sum() == pytest.approx(float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2)


def test_left_handed_faces_and_mirrored_ones_are_turned_round(stage: Any) -> None:
    mesh(stage, "/LeftHanded", orientation="leftHanded")
    mesh(stage, "/Mirrored").AddScaleOp().Set(Gf.Vec3f(-1, 1, 1))
    mesh(stage, "/Both", orientation="leftHanded").AddScaleOp().Set(Gf.Vec3f(-1, 1, 1))
    assert facing(loaded(stage)) == [[0, 0, -1], UP, [0, 0, -1]]


def test_normals_follow_corners_and_transform_and_a_sharp_edge_has_two_where_a_flat_one_has_one(stage: Any) -> None:
    tilted = mesh(stage, "/Tilted", normals=[Gf.Vec3f(1, 0, 1)] * 4)
    tilted.SetNormalsInterpolation("faceVarying")
    tilted.AddScaleOp().Set(Gf.Vec3f(2, 1, 1))
    corners, faces = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 1, 2, 3), (0, 3, 5, 4)]
    mesh(stage, "/Sharp", [*corners, (0, 0, 1), (0, 1, 1)], faces)
    mesh(stage, "/Flat", [*corners, (-1, 0, 0.1), (-1, 1, 0.1)], faces)
    found = loaded(stage).meshes
    assert np.allclose(found[0].normals, np.array([0.5, 0, 1]) / np.sqrt(1.25))
    assert [len(one.points) for one in found[1:]] == [8, 6]


def test_colours_per_point_per_face_and_per_corner_reach_the_corners(stage: Any) -> None:
    points = [(x, y, 0) for y in range(2) for x in range(3)]
    faces = [(0, 1, 4, 3), (1, 2, 5, 4)]
    red, green = Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 1, 0)
    for name, values in {"vertex": 6, "uniform": 2, "faceVarying": 8}.items():
        made = mesh(stage, f"/{name}", points, faces)
        colours = [red] * (values // 2) + [green] * (values // 2)
        primvar(made, "displayColor", NAMES.Color3fArray, name, colours)
    by_path = {mesh.path: mesh for mesh in loaded(stage).meshes}
    for path in ("/uniform", "/faceVarying"):
        found = by_path[path]
        corners = found.vertex_colours[found.triangles].reshape(4, 9).tolist()
        assert corners == [[255, 0, 0] * 3] * 2 + [[0, 255, 0] * 3] * 2
        assert len(found.points) == 8
    assert len(by_path["/vertex"].points) == 6


def test_a_colour_is_inherited_opacity_is_kept_and_indexed_colours_are_looked_up(stage: Any) -> None:
    parent = UsdGeom.Xform.Define(stage, "/Group")
    primvar(parent, "displayColor", NAMES.Color3fArray, "constant", [Gf.Vec3f(1, 0, 0)])
    mesh(stage, "/Group/Pane").CreateDisplayOpacityAttr([0.25])
    shades = primvar(mesh(stage, "/Floor"), "displayColor", NAMES.Color3fArray, "vertex", [Gf.Vec3f(0), Gf.Vec3f(1)])
    shades.SetIndices(Vt.IntArray([0, 1, 1, 0]))
    pane, floor = loaded(stage).meshes
    assert (pane.colour, pane.opacity) == (pytest.approx((1, 0, 0)), 0.25)
    white = floor.points[floor.vertex_colours[:, 0] == 255]
    assert sorted(white.tolist()) == [[1, 0, 0], [1, 1, 0]]


def test_animated_points_are_those_of_the_start(stage: Any) -> None:
    stage.SetStartTimeCode(10)
    stage.SetEndTimeCode(20)
    points = mesh(stage, "/Floor").GetPointsAttr()
    points.Set([Gf.Vec3f(*point) * 5 for point in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))], 10)
    points.Set([Gf.Vec3f(0)] * 4, 20)
    assert loaded(stage).bounds.tolist() == [[0, 0, 0], [5, 5, 0]]


SHAPES = [
    ("Cube", {"size": 3.0}, 27.0),
    ("Sphere", {"radius": 2.0}, 32 / 3 * np.pi),
    *(("Cylinder", {"radius": 1.0, "height": 3.0, "axis": axis}, 3 * np.pi) for axis in "XYZ"),
    *(("Cone", {"radius": 1.0, "height": 3.0, "axis": axis}, np.pi) for axis in "XYZ"),
    *(("Capsule", {"radius": 1.0, "height": 3.0, "axis": axis}, 13 / 3 * np.pi) for axis in "XYZ"),
]


@pytest.mark.parametrize(("kind", "attributes", "volume"), SHAPES)
def test_a_shape_has_the_bounds_and_the_volume_of_its_schema(
    stage: Any, kind: str, attributes: dict[str, Any], volume: float
) -> None:
    prim = stage.DefinePrim("/Shape", kind)
    for name, value in attributes.items():
        prim.GetAttribute(name).Set(value)
    extent = UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(prim), Usd.TimeCode.Default())
    scene = loaded(stage)
    assert np.allclose(scene.bounds, np.array(extent), atol=0.01)
    found = one_mesh(scene)
    a, b, c = (found.points[found.triangles[:, corner]] for corner in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 == pytest.approx(volume, rel=0.03)


@pytest.mark.parametrize(
    ("axis", "size", "normal"), [("X", [0, 4, 2], [1, 0, 0]), ("Y", [2, 0, 4], [0, 1, 0]), ("Z", [2, 4, 0], UP)]
)
def test_a_plane_faces_along_its_axis(stage: Any, axis: str, size: list[float], normal: list[float]) -> None:
    plane = UsdGeom.Plane.Define(stage, "/Plane")
    plane.CreateWidthAttr(2.0)
    plane.CreateLengthAttr(4.0)
    plane.CreateAxisAttr(axis)
    scene = loaded(stage)
    assert np.ptp(scene.bounds, axis=0).tolist() == size
    assert facing(scene) == [normal]


def moved(stage: Any, path: str, *shift: float) -> Any:
    made = UsdGeom.Xform.Define(stage, path)
    made.AddTranslateOp().Set(Gf.Vec3d(*shift))
    return made


def tile(tmp_path: Path, name: str = "tile.usda", size: float = 1) -> str:
    """Write a file with a tile below /Tile, one metre wide and of this size along x, and return its name."""
    stage = new_stage(tmp_path / name)
    UsdGeom.Xform.Define(stage, "/Tile")
    mesh(stage, "/Tile/Face", [(0, 0, 0), (size, 0, 0), (size, 1, 0), (0, 1, 0)])
    loaded(stage)
    return f"./{name}"


def test_references_payloads_and_instances_are_loaded_each_at_its_place(stage: Any, tmp_path: Path) -> None:
    name = tile(tmp_path)
    stage.DefinePrim("/A").GetReferences().AddReference(name)
    moved(stage, "/B", 5, 0, 0).GetPrim().GetPayloads().AddPayload(name)
    for number in range(2):
        prim = moved(stage, f"/Row/Tile{number}", 2 * number, 0, 0).GetPrim()
        prim.GetReferences().AddReference(name)
        prim.SetInstanceable(True)
    scene = loaded(stage)
    assert paths(scene) == ["/A/Face", "/B/Face", "/Row/Tile0/Face", "/Row/Tile1/Face"]
    assert [mesh.points[:, 0].min() for mesh in scene.meshes] == [0, 5, 0, 2]


def test_a_point_instancer_draws_copies_of_its_prototypes_and_not_the_prototypes(stage: Any) -> None:
    moved(stage, "/Group", 0, 0, 7)
    places = [(10 * number, 0, 0) for number in range(1, 5)]
    made = instancer(stage, "/Group/Trees", ["/Group/Trees/Low", "/Group/Trees/High"], [0, 0, 1, 0], places)
    made.CreateScalesAttr([Gf.Vec3f(1), Gf.Vec3f(3), Gf.Vec3f(1), Gf.Vec3f(1)])
    made.CreateInvisibleIdsAttr([3])
    mesh(stage, "/Group/Trees/Low/Face")
    mesh(stage, "/Group/Trees/High", [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
    scene = loaded(stage)
    assert paths(scene) == ["/Group/Trees/Low/Face", "/Group/Trees/High"]
    assert scene.triangles == 3 * 2
    assert scene.bounds.tolist() == [[10, 0, 7], [31, 3, 8]]


def test_instancers_nest_and_take_prototypes_from_elsewhere(stage: Any) -> None:
    UsdGeom.Xform.Define(stage, "/World")
    stage.CreateClassPrim("/Library")
    mesh(stage, "/Library/Leaf").AddTranslateOp().Set(Gf.Vec3d(0, 0, 1))
    instancer(stage, "/Library/Row", ["/Library/Leaf"], [0, 0], [(0, 0, 0), (2, 0, 0)])
    instancer(stage, "/World/Field", ["/Library/Row"], [0, 0, 0], [(0, 0, 0), (0, 2, 0), (0, 4, 0)])
    scene = loaded(stage)
    assert paths(scene) == ["/World/Field/Row/Leaf"]
    assert scene.triangles == 2 * 3 * 2
    assert scene.bounds.tolist() == [[0, 0, 1], [3, 5, 1]]


def test_mirrored_copies_keep_their_outside(stage: Any) -> None:
    made = instancer(stage, "/I", ["/I/Face"], [0, 0], [(0, 0, 0), (5, 0, 0)])
    made.CreateScalesAttr([Gf.Vec3f(-1, 1, 1), Gf.Vec3f(1)])
    mesh(stage, "/I/Face")
    scene = loaded(stage)
    assert facing(scene) == [UP]
    assert scene.meshes[0].normals.tolist() == [UP] * 8


def test_what_is_hidden_inactive_for_guidance_or_excluded_is_not_drawn(stage: Any) -> None:
    mesh(stage, "/World/Seen")
    UsdGeom.Xform.Define(stage, "/World/Hidden").MakeInvisible()
    mesh(stage, "/World/Hidden/Face")
    mesh(stage, "/World/Off").GetPrim().SetActive(False)
    for purpose in ("guide", "proxy", "render"):
        UsdGeom.Xform.Define(stage, f"/World/For_{purpose}").CreatePurposeAttr(purpose)
        mesh(stage, f"/World/For_{purpose}/Face")
    mesh(stage, "/World/Earth/Ball", [(0, 0, 0), (900, 0, 0), (0, 900, 0)], [(0, 1, 2)])
    mesh(stage, "/World/Earth_Clouds/Ball")
    scene = loaded(stage, exclude=["*/Earth*", "/World/Mars"])
    assert paths(scene) == ["/World/Seen", "/World/For_render/Face"]
    assert scene.bounds.tolist() == [[0, 0, 0], [1, 1, 0]]
    assert scene.warnings == ("Pattern of `exclude` that matches no prim: /World/Mars",)


def test_things_are_labelled_by_semantics_by_isaac_and_by_kind_and_two_may_share_a_label(stage: Any) -> None:
    for name in ("Sign", "Rack", "Blue_chair", "Lamp", "Floor"):
        mesh(stage, f"/World/{name}/Face")
    prim = {name: stage.GetPrimAtPath(f"/World/{name}") for name in ("Sign", "Rack", "Blue_chair", "Lamp")}
    UsdSemantics.LabelsAPI.Apply(prim["Sign"], "foundry").CreateLabelsAttr(["JAXA logo", "logo"])
    UsdSemantics.LabelsAPI.Apply(prim["Sign"], "class").CreateLabelsAttr(["sign"])
    isaac = prim["Rack"].CreateAttribute("semantic:Semantics_ab12:params:semanticData", Sdf.ValueTypeNames.String)
    isaac.Set("rack")
    Usd.ModelAPI(prim["Blue_chair"]).SetKind("component")
    Usd.ModelAPI(prim["Lamp"]).SetKind("component")
    prim["Lamp"].SetDisplayName("desk lamp")
    for number in range(2):
        hatch = mesh(stage, f"/World/Hatch{number}").GetPrim()
        UsdSemantics.LabelsAPI.Apply(hatch, "class").CreateLabelsAttr(["hatch"])
    scene = loaded(stage)
    assert scene.labels == {
        "JAXA logo": ("/World/Sign",),
        "rack": ("/World/Rack",),
        "Blue chair": ("/World/Blue_chair",),
        "desk lamp": ("/World/Lamp",),
        "hatch": ("/World/Hatch0", "/World/Hatch1"),
    }
    assert [mesh.label for mesh in scene.meshes] == [
        "JAXA logo", "rack", "Blue chair", "desk lamp", None, "hatch", "hatch"
    ]  # fmt: skip


def test_a_scene_is_loaded_once_and_again_when_it_or_what_it_refers_to_changed(stage: Any, tmp_path: Path) -> None:
    mesh(stage, "/Floor")
    first = loaded(stage)
    assert load_scene(tmp_path / "scene.usda") is first
    second = load_scene(write_stage(tmp_path / "other.usda", lambda stage: mesh(stage, "/Floor")))
    third = load_scene(write_stage(tmp_path / "third.usda", lambda stage: mesh(stage, "/Ground")))
    assert first.sha256 == second.sha256 != third.sha256
    assert load_scene(tmp_path / "third.usda", exclude=["/Nothing"]).sha256 != third.sha256
    digests = []
    for size in (1, 2):
        name = tile(tmp_path, f"tile{size}.usda", size)
        (tmp_path / "tile.usda").write_bytes((tmp_path / name).read_bytes())
        root = tmp_path / f"root{size}.usda"
        text = '#usda 1.0\n(upAxis = "Z"\nmetersPerUnit = 1)\ndef "A" (references = @./tile{}.usda@</Tile>) {{}}\n'
        root.write_text(text.format(size), encoding="utf-8")
        digests.append(load_scene(root).sha256)
    assert digests[0] != digests[1]


def test_files_that_are_missing_broken_or_empty_are_refused_in_one_line(
    stage: Any, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    write_stage(tmp_path / "kibo.usda", lambda stage: mesh(stage, "/Floor"))
    with pytest.raises(InputError, match=r"Scene '.*kibbo\.usda' not found\. Did you mean '.*kibo\.usda'\?"):
        load_scene(tmp_path / "kibbo.usda")
    (tmp_path / "kibo.obj").touch()
    with pytest.raises(InputError, match="is not a USD scene. Its name must end in .usd, .usda, .usdc, .usdz"):
        load_scene(tmp_path / "kibo.obj")
    (tmp_path / "broken.usda").write_text("#usda 1.0\ndef Mesh {", encoding="utf-8")
    with pytest.raises(InputError, match="cannot be opened as a USD stage") as broken:
        load_scene(tmp_path / "broken.usda")
    with pytest.raises(InputError, match="shows nothing that can be drawn") as empty:
        loaded(stage)
    assert not re.search(r"\n", f"{broken.value}{empty.value}")
    assert capfd.readouterr().err == ""
