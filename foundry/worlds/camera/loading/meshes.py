"""Cuts polygons and USD's shapes into triangles, places them in the scene, and converts them to VTK's data."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt
from vtkmodules.util import numpy_support
from vtkmodules.vtkCommonCore import vtkIdList, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData, vtkPolygon
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals

from foundry.worlds.camera.loading.scene import FloatArray, IntArray, SceneMesh, UInt8Array


@dataclass(frozen=True, eq=False)
class Topology:
    """The triangles of one prim in its own space.

    Attributes:
        points: (n, 3).
        triangles: (m, 3) indices of points.
        corners: (m, 3) indices of face-vertices, for face-varying data.
        faces: (m,) index of each triangle's face.
    """

    points: FloatArray
    triangles: IntArray
    corners: IntArray
    faces: IntArray

    def flipped(self) -> "Topology":
        """Return the triangles with their front and back exchanged."""
        return Topology(self.points, self.triangles[:, ::-1], self.corners[:, ::-1], self.faces)

    def chosen(self, rows: IntArray) -> "Topology":
        """Return only the triangles with these indices."""
        return Topology(self.points, self.triangles[rows], self.corners[rows], self.faces[rows])


def triangulated(points: FloatArray, counts: IntArray, indices: IntArray, holes: IntArray) -> Topology:
    """Cut faces into triangles, except holes and faces with fewer than three corners.

    Args:
        points: (n, 3).
        counts: (f,) number of each face's corners.
        indices: (sum of counts,) index of each corner's point, face after face.
        holes: (h,) indices of the faces to leave out.
    """
    starts = np.concatenate([[0], np.cumsum(counts)[:-1]]).astype(np.int64)
    drawn = counts >= 3
    drawn[holes[(holes >= 0) & (holes < len(counts))]] = False
    corners, faces = [], []
    for size in np.unique(counts[drawn]):
        which = np.flatnonzero(drawn & (counts == size))
        polygons = starts[which][:, None] + np.arange(size)
        cut = _cut(points[indices[polygons]])
        corners.append(np.take_along_axis(polygons[:, None, :], cut, axis=2).reshape(-1, 3))
        faces.append(np.repeat(which, size - 2))
    all_corners = np.concatenate(corners) if corners else np.zeros((0, 3), np.int64)
    all_faces = np.concatenate(faces) if faces else np.zeros(0, np.int64)
    order = np.argsort(all_faces, kind="stable")
    return Topology(points, indices[all_corners[order]], all_corners[order], all_faces[order])


def _cut(polygons: FloatArray) -> IntArray:
    """Cut (f, s, 3) polygons into triangles; return, (f, s - 2, 3), the corners' numbers, counted in each polygon."""
    count, size = polygons.shape[:2]
    normals = np.cross(polygons, np.roll(polygons, -1, axis=1)).sum(axis=1)
    cut = np.zeros((count, size - 2, 3), np.int64)
    open_ones = np.arange(count)
    for first in range(min(size, 2) if size > 3 else 1):
        fan = _fan(size, first)
        good = _is_sound(polygons[open_ones], normals[open_ones], fan)
        cut[open_ones if first == 0 else open_ones[good]] = fan
        open_ones = open_ones[~good]
    if size > 4:
        for face in open_ones:
            cut[face] = _ears(polygons[face])
    return cut


def _fan(size: int, first: int) -> IntArray:
    rest = (first + 1 + np.arange(size - 1)) % size
    return np.stack([np.full(size - 2, first), rest[:-1], rest[1:]], axis=1)


def _is_sound(polygons: FloatArray, normals: FloatArray, fan: IntArray) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Return, for each polygon, whether all triangles of its fan around one corner face the same way as it."""
    a, b, c = (polygons[:, fan[:, i]] for i in range(3))
    facing = np.einsum("fti,fi->ft", np.cross(b - a, c - a), normals)
    return np.asarray((facing >= 0).all(axis=1))


def _ears(polygon: FloatArray) -> IntArray:
    """Cut one (s, 3) polygon into triangles by ear clipping, or into a fan of triangles if this fails."""
    size, ids = len(polygon), vtkIdList()
    shape: Any = vtkPolygon()
    shape.GetPoints().SetNumberOfPoints(size)
    shape.GetPointIds().SetNumberOfIds(size)
    for corner, point in enumerate(polygon.tolist()):
        shape.GetPoints().SetPoint(corner, point)
        shape.GetPointIds().SetId(corner, corner)
    if not shape.EarCutTriangulation(ids) or ids.GetNumberOfIds() != 3 * (size - 2):
        return _fan(size, 0)
    return np.array([ids.GetId(number) for number in range(ids.GetNumberOfIds())]).reshape(-1, 3)


AROUND = 32
"""Number of sides of round shapes; with so many sides, shading makes them look round."""

AXES: Mapping[str, tuple[int, int, int]] = MappingProxyType({"X": (2, 0, 1), "Y": (1, 2, 0), "Z": (0, 1, 2)})
"""A shape is first made along Z; for each axis, the numbers of its coordinates that then become x, y and z."""


def _polygons(points: FloatArray, faces: list[list[int]], axis: str = "Z") -> Topology:
    counts = np.array([len(face) for face in faces], np.int64)
    indices = np.array([corner for face in faces for corner in face], np.int64)
    return triangulated(points[:, AXES[axis]], counts, indices, np.zeros(0, np.int64))


@lru_cache(maxsize=64)
def box(size: float) -> Topology:
    """Return a cube of this edge length."""
    points = (np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)]) - 0.5) * size
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    return _polygons(points, faces)


def turned(profile: FloatArray, axis: str = "Z") -> Topology:
    """Return the solid that a profile makes when it turns around an axis; ends of radius 0 close it.

    Args:
        profile: (k, 2) radius and height, from the bottom up.
        axis: `X`, `Y` or `Z`.
    """
    angles = np.arange(AROUND) * (2 * np.pi / AROUND)
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    radii, heights = profile.T
    points = np.concatenate(
        [np.repeat(radii, AROUND)[:, None] * np.tile(ring, (len(profile), 1)), np.repeat(heights, AROUND)[:, None]],
        axis=1,
    )
    rows = np.arange(len(profile))[:, None] * AROUND
    ids: IntArray = np.where(radii[:, None] == 0, rows, rows + np.arange(AROUND))
    faces = []
    for low, high in zip(ids[:-1], ids[1:], strict=True):
        for i in range(AROUND):
            j = (i + 1) % AROUND
            faces.append(list(dict.fromkeys([int(low[i]), int(low[j]), int(high[j]), int(high[i])])))
    return _polygons(points, faces, axis)


def _arc(radius: float, centre: float, start: float, end: float) -> FloatArray:
    """Return a part of a circle as a profile (k, 2) of radius and height; angles in degrees, -90 at the bottom."""
    angles = np.radians(np.linspace(start, end, 1 + round(AROUND * abs(end - start) / 360)))
    points = np.stack([radius * np.cos(angles), centre + radius * np.sin(angles)], axis=1)
    points[np.abs(np.cos(angles)) < 1e-9, 0] = 0
    return points


@lru_cache(maxsize=64)
def sphere(radius: float) -> Topology:
    """Return a sphere."""
    return turned(_arc(radius, 0, -90, 90))


@lru_cache(maxsize=64)
def cylinder(bottom: float, top: float, height: float, axis: str) -> Topology:
    """Return a closed cylinder with the given radii at its ends; a cone if one radius is 0."""
    half = height / 2
    return turned(np.array([[0, -half], [bottom, -half], [top, half], [0, half]]), axis)


@lru_cache(maxsize=64)
def capsule(bottom: float, top: float, height: float, axis: str) -> Topology:
    """Return a cylinder of this height between two half spheres."""
    half = height / 2
    return turned(np.concatenate([_arc(bottom, -half, -90, 0), _arc(top, half, 0, 90)]), axis)


def plane(width: float, length: float, axis: str) -> Topology:
    """Return a rectangle whose normal is an axis of the scene.

    The width is along x, or along z for the axis X. The length is along y, or along z for the axis Y.
    """
    u, v = {"X": (2, 1), "Y": (0, 2), "Z": (0, 1)}[axis]
    points = np.zeros((4, 3))
    points[:, u] = np.array([-1, 1, 1, -1]) * width / 2
    points[:, v] = np.array([-1, -1, 1, 1]) * length / 2
    order = [0, 1, 2, 3] if axis == "Z" else [3, 2, 1, 0]
    return _polygons(points, [order])


Size = Callable[[str], float]
"""A function that returns the value of a shape's attribute, such as `radius`, by the attribute's name."""

Axis = Callable[[], str]
"""A function that returns the axis of a shape: X, Y or Z."""

SHAPES: Mapping[str, Callable[[Size, Axis], Topology]] = MappingProxyType(
    {
        "Cube": lambda size, axis: box(size("size")),
        "Sphere": lambda size, axis: sphere(size("radius")),
        "Cylinder": lambda size, axis: cylinder(size("radius"), size("radius"), size("height"), axis()),
        "Cylinder_1": lambda size, axis: cylinder(size("radiusBottom"), size("radiusTop"), size("height"), axis()),
        "Cone": lambda size, axis: cylinder(size("radius"), 0.0, size("height"), axis()),
        "Capsule": lambda size, axis: capsule(size("radius"), size("radius"), size("height"), axis()),
        "Capsule_1": lambda size, axis: capsule(size("radiusBottom"), size("radiusTop"), size("height"), axis()),
        "Plane": lambda size, axis: plane(size("width"), size("length"), axis()),
    }
)
"""For each primitive shape of UsdGeom, such as `Cube`, the function that makes it."""


_Scalar = TypeVar("_Scalar", bound=np.generic)


def weld(columns: list[npt.NDArray[np.generic]]) -> tuple[IntArray, IntArray]:
    """Merge equal corners.

    Args:
        columns: arrays (c, k) of the corners' values; corners that agree in all of them are equal.

    Returns:
        The index of the first of each group of equal corners (n,), and the group of each corner (c,).
    """
    bits = [np.ascontiguousarray(column, np.float64).view(np.uint64) for column in columns]
    # One 64-bit hash per corner: sorting whole rows takes ten times as long on a million triangles.
    keys = np.zeros(len(columns[0]), np.uint64)
    for column in np.concatenate(bits, axis=1).T:
        keys = (keys ^ column) * np.uint64(0x9E3779B97F4A7C15)
        keys ^= keys >> np.uint64(29)
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    return first.astype(np.int64), inverse.astype(np.int64)


def placed(mesh: SceneMesh, matrices: FloatArray) -> SceneMesh:
    """Return one mesh that joins k copies of this mesh, one for each of the transforms (k, 4, 4); points are rows."""
    linear, count = matrices[:, :3, :3], len(mesh.points)
    with np.errstate(all="ignore"):  # a file may place things at invalid positions; the loader leaves these out
        points = mesh.points @ linear + matrices[:, None, 3, :3]
        mirrored = np.linalg.det(linear) < 0
        normals = None if mesh.normals is None else _turned_normals(mesh.normals, linear, mirrored)
    triangles = mesh.triangles + (np.arange(len(matrices)) * count)[:, None, None]
    triangles[mirrored] = triangles[mirrored][..., ::-1]
    return replace(
        mesh,
        points=points.reshape(-1, 3),
        triangles=triangles.reshape(-1, 3),
        normals=normals,
        uvs=_repeated(mesh.uvs, len(matrices)),
        vertex_colours=_repeated(mesh.vertex_colours, len(matrices)),
    )


def _turned_normals(normals: FloatArray, linear: FloatArray, mirrored: npt.NDArray[np.bool_]) -> FloatArray:
    """Transform normals (n, 3) by the cofactors of each matrix; they exist even if a scale is 0, unlike the inverse."""
    cofactors = np.cross(np.roll(linear, -1, axis=1), np.roll(linear, -2, axis=1))
    signs = np.where(mirrored, -1.0, 1.0)[:, None, None]
    turned = (normals @ cofactors * signs).reshape(-1, 3)
    lengths = np.linalg.norm(turned, axis=1, keepdims=True)
    return np.asarray(turned / np.where(lengths == 0, 1, lengths))


def _repeated(values: npt.NDArray[_Scalar] | None, times: int) -> npt.NDArray[_Scalar] | None:
    return None if values is None else np.tile(values, (times, 1))


_support: Any = numpy_support

FEATURE_ANGLE = 30.0
"""Smallest angle between two faces at which their edge looks sharp, degrees."""


def polydata(points: FloatArray, triangles: IntArray) -> Any:
    """Return a vtkPolyData with copies of (n, 3) points, in single precision, and (m, 3) triangles."""
    corners = vtkPoints()
    corners.SetData(floats(points))
    cells = vtkCellArray()
    cells.SetData(3, _support.numpy_to_vtkIdTypeArray(np.ascontiguousarray(triangles, np.int64).ravel(), deep=True))
    data = vtkPolyData()
    data.SetPoints(corners)
    data.SetPolys(cells)
    return data


def floats(values: FloatArray) -> Any:
    """Return (n, k) values as a VTK array of single precision."""
    return _support.numpy_to_vtk(np.ascontiguousarray(values, np.float32), deep=True)


def byte_values(values: UInt8Array) -> Any:
    """Return (n, k) bytes as a VTK array."""
    return _support.numpy_to_vtk(np.ascontiguousarray(values), deep=True)


def as_numpy(array: Any) -> npt.NDArray[Any]:
    """Return the values of a VTK array as a NumPy array that shares its memory."""
    return np.asarray(_support.vtk_to_numpy(array))


def corner_normals(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Return the normals at the triangles' corners, (m, 3, 3), smoothed except across sharp edges."""
    normals = vtkPolyDataNormals()
    normals.SetInputData(polydata(points, triangles))
    normals.SetFeatureAngle(FEATURE_ANGLE)
    normals.ConsistencyOff()
    normals.SplittingOn()
    normals.Update()
    out = normals.GetOutput()
    values = as_numpy(out.GetPointData().GetNormals())
    triangles = as_numpy(out.GetPolys().GetConnectivityArray()).astype(np.int64).reshape(-1, 3)
    return np.asarray(values[triangles], np.float64)
