"""Faces, normals, colours and shapes of a stage come out as triangles."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

from foundry.worlds.camera.loading.meshes import triangulated
from foundry.worlds.camera.loading.scene import Scene
from worlds.camera.usd_files import facing, load, mesh, primvar

NAMES = Sdf.ValueTypeNames


def one(scene: Any) -> Any:
    assert len(scene.meshes) == 1
    return scene.meshes[0]


def test_a_square_becomes_two_triangles_that_face_up(tmp_path: Path) -> None:
    scene = load(tmp_path, lambda stage: mesh(stage, "/Floor"))
    assert (one(scene).path, scene.triangles, len(one(scene).points)) == ("/Floor", 2, 4)
    assert scene.bounds.tolist() == [[0, 0, 0], [1, 1, 0]]
    assert facing(scene) == [[0, 0, 1]]
    assert one(scene).normals.tolist() == [[0, 0, 1]] * 4
    assert scene.warnings == ()


def test_conventions_of_a_file_become_z_up_and_metres_and_those_of_usd_are_taken_with_a_warning(tmp_path: Path) -> None:
    wall = ((100, 0, -30), (200, 0, -30), (200, 50, -30))
    scene = load(tmp_path, lambda stage: mesh(stage, "/Wall", wall, [(0, 1, 2)]), up="Y", unit=0.01)
    assert np.allclose(scene.bounds, [[1, 0.3, 0], [2, 0.3, 0.5]])
    assert (scene.up_axis, scene.metres_per_unit) == ("Y", 0.01)
    assert facing(scene) == [[0, -1, 0]]
    scene = load(tmp_path, lambda stage: mesh(stage, "/Floor"), up=None, unit=None)
    assert (scene.up_axis, scene.metres_per_unit) == ("Y", 0.01)
    assert [line.split(":")[0] for line in scene.warnings] == ["No upAxis in the file", "No metersPerUnit in the file"]


def area(scene: Scene) -> float:
    """Return the area of all triangles, square metres."""
    total = 0.0
    for one in scene.meshes:
        a, b, c = (one.points[one.triangles[:, corner]] for corner in range(3))
        total += float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2
    return total


def test_faces_of_many_corners_and_concave_ones_keep_their_area(tmp_path: Path) -> None:
    angles = np.arange(7) * (2 * np.pi / 7)
    points = np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    scene = load(tmp_path, lambda stage: mesh(stage, "/Disc", points.tolist(), [range(7)]))
    assert scene.triangles == 5
    assert area(scene) == pytest.approx(3.5 * np.sin(2 * np.pi / 7), rel=1e-6)
    dart = [(0, 0, 0), (2, 0, 0), (0.5, 0.5, 0), (0, 2, 0)]
    ell = [(0, 0, 1), (3, 0, 1), (3, 1, 1), (1, 1, 1), (1, 3, 1), (0, 3, 1)]
    cup = [(0, 0, 2), (4, 0, 2), (4, 3, 2), (3, 3, 2), (3, 1, 2), (1, 1, 2), (1, 3, 2), (0, 3, 2)]
    faces = [range(4), range(4, 10), range(10, 18)]
    scene = load(tmp_path, lambda stage: mesh(stage, "/Shapes", [*dart, *ell, *cup], faces))
    assert scene.triangles == 2 + 4 + 6
    assert area(scene) == pytest.approx(1 + 5 + 8)
    points = [(x, y, 0) for y in range(2) for x in range(3)]
    faces = [(0, 1, 4, 3), (1, 2, 5, 4), (0, 1)]
    scene = load(tmp_path, lambda stage: mesh(stage, "/Floor", points, faces, holeIndices=[1]))
    assert (scene.triangles, area(scene)) == (2, 1)


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


def test_left_handed_faces_and_mirrored_ones_are_turned_round(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        mesh(stage, "/LeftHanded", orientation="leftHanded")
        mesh(stage, "/Mirrored").AddScaleOp().Set(Gf.Vec3f(-1, 1, 1))
        both = mesh(stage, "/Both", orientation="leftHanded")
        both.AddScaleOp().Set(Gf.Vec3f(-1, 1, 1))

    assert facing(load(tmp_path, build)) == [[0, 0, -1], [0, 0, 1], [0, 0, -1]]


def test_authored_normals_follow_the_corners_and_the_transform(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        tilted = mesh(stage, "/Tilted", normals=[Gf.Vec3f(1, 0, 1)] * 4)
        tilted.SetNormalsInterpolation("faceVarying")
        tilted.AddScaleOp().Set(Gf.Vec3f(2, 1, 1))

    expected = np.array([0.5, 0, 1]) / np.sqrt(1.25)
    assert np.allclose(one(load(tmp_path, build)).normals, expected)


def test_a_sharp_edge_has_two_normals_and_a_flat_one_has_one(tmp_path: Path) -> None:
    sharp = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (0, 1, 1)]
    flat = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (-1, 0, 0.1), (-1, 1, 0.1)]
    faces = [(0, 1, 2, 3), (0, 3, 5, 4)]

    def build(stage: Any) -> None:
        mesh(stage, "/Sharp", sharp, faces)
        mesh(stage, "/Flat", flat, faces)

    scene = load(tmp_path, build)
    assert [len(found.points) for found in scene.meshes] == [8, 6]


def test_display_colours_are_turned_from_linear_light_to_srgb(tmp_path: Path) -> None:
    scene = load(tmp_path, lambda stage: mesh(stage, "/Floor").CreateDisplayColorAttr([Gf.Vec3f(0.2140, 0, 1)]))
    assert one(scene).colour == pytest.approx((0.5, 0, 1), abs=1e-3)
    assert one(scene).vertex_colours is None


def test_colours_per_point_per_face_and_per_corner_reach_the_corners(tmp_path: Path) -> None:
    points = [(x, y, 0) for y in range(2) for x in range(3)]
    faces = [(0, 1, 4, 3), (1, 2, 5, 4)]
    red, green = Gf.Vec3f(1, 0, 0), Gf.Vec3f(0, 1, 0)

    def build(stage: Any) -> None:
        for name, values in {"vertex": 6, "uniform": 2, "faceVarying": 8}.items():
            made = mesh(stage, f"/{name}", points, faces)
            colours = [red] * (values // 2) + [green] * (values // 2)
            primvar(made, "displayColor", NAMES.Color3fArray, name, colours)

    by_path = {found.path: found for found in load(tmp_path, build).meshes}
    for path in ("/uniform", "/faceVarying"):
        found = by_path[path]
        corners = found.vertex_colours[found.triangles].reshape(4, 9).tolist()
        assert corners == [[255, 0, 0] * 3] * 2 + [[0, 255, 0] * 3] * 2
        assert len(found.points) == 8
    assert len(by_path["/vertex"].points) == 6


def test_a_colour_is_inherited_from_the_parent_and_opacity_is_kept(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        parent = UsdGeom.Xform.Define(stage, "/Group")
        primvar(parent, "displayColor", NAMES.Color3fArray, "constant", [Gf.Vec3f(1, 0, 0)])
        mesh(stage, "/Group/Pane").CreateDisplayOpacityAttr([0.25])

    found = one(load(tmp_path, build))
    assert (found.colour, found.opacity) == (pytest.approx((1, 0, 0)), 0.25)


def test_indexed_colours_are_looked_up(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        made = primvar(mesh(stage, "/Floor"), "displayColor", NAMES.Color3fArray, "vertex", [Gf.Vec3f(0), Gf.Vec3f(1)])
        made.SetIndices(Vt.IntArray([0, 1, 1, 0]))

    found = one(load(tmp_path, build))
    white = found.points[found.vertex_colours[:, 0] == 255]
    assert sorted(white.tolist()) == [[1, 0, 0], [1, 1, 0]]


def test_animated_points_are_those_of_the_start(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        stage.SetStartTimeCode(10)
        stage.SetEndTimeCode(20)
        points = mesh(stage, "/Floor").GetPointsAttr()
        points.Set([Gf.Vec3f(*point) * 5 for point in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))], 10)
        points.Set([Gf.Vec3f(0)] * 4, 20)

    assert load(tmp_path, build).bounds.tolist() == [[0, 0, 0], [5, 5, 0]]


SHAPES = [
    ("Cube", {"size": 3.0}, 27.0),
    ("Sphere", {"radius": 2.0}, 32 / 3 * np.pi),
    *(("Cylinder", {"radius": 1.0, "height": 3.0, "axis": axis}, 3 * np.pi) for axis in "XYZ"),
    *(("Cone", {"radius": 1.0, "height": 3.0, "axis": axis}, np.pi) for axis in "XYZ"),
    *(("Capsule", {"radius": 1.0, "height": 3.0, "axis": axis}, 13 / 3 * np.pi) for axis in "XYZ"),
]


@pytest.mark.parametrize(("kind", "attributes", "volume"), SHAPES)
def test_a_shape_has_the_bounds_and_the_volume_of_its_schema(
    tmp_path: Path, kind: str, attributes: dict[str, Any], volume: float
) -> None:
    extents = []

    def build(stage: Any) -> None:
        prim = stage.DefinePrim("/Shape", kind)
        for name, value in attributes.items():
            prim.GetAttribute(name).Set(value)
        extents.append(UsdGeom.Boundable.ComputeExtentFromPlugins(UsdGeom.Boundable(prim), Usd.TimeCode.Default()))

    scene = load(tmp_path, build)
    assert np.allclose(scene.bounds, np.array(extents[0]), atol=0.01)
    a, b, c = (one(scene).points[one(scene).triangles[:, corner]] for corner in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 == pytest.approx(volume, rel=0.03)


@pytest.mark.parametrize(
    ("axis", "size", "normal"), [("X", [0, 4, 2], [1, 0, 0]), ("Y", [2, 0, 4], [0, 1, 0]), ("Z", [2, 4, 0], [0, 0, 1])]
)
def test_a_plane_faces_along_its_axis(tmp_path: Path, axis: str, size: list[float], normal: list[float]) -> None:
    def build(stage: Any) -> None:
        plane = UsdGeom.Plane.Define(stage, "/Plane")
        plane.CreateWidthAttr(2.0)
        plane.CreateLengthAttr(4.0)
        plane.CreateAxisAttr(axis)

    scene = load(tmp_path, build)
    assert np.ptp(scene.bounds, axis=0).tolist() == size
    assert facing(scene) == [normal]


def test_round_shapes_are_smooth_and_boxes_are_not(tmp_path: Path) -> None:
    def build(stage: Any) -> None:
        UsdGeom.Sphere.Define(stage, "/Sphere")
        UsdGeom.Cube.Define(stage, "/Cube")

    ball, cube = load(tmp_path, build).meshes
    assert np.allclose(ball.normals, ball.points / np.linalg.norm(ball.points, axis=1, keepdims=True), atol=0.05)
    assert len(cube.points) == 24
