"""Converts one drawable prim of a stage to meshes in its own space: geometry, primvars and materials."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from pxr import UsdGeom, UsdShade

from foundry.worlds.camera.loading.materials import Look, Materials, to_srgb
from foundry.worlds.camera.loading.meshes import AXES, SHAPES, Topology, corner_normals, triangulated, weld
from foundry.worlds.camera.loading.scene import Colour, FloatArray, IntArray, SceneMesh, UInt8Array
from foundry.worlds.camera.loading.values import LARGEST, Findings, Values

GREY: Colour = (0.7, 0.7, 0.7)
"""Colour of surfaces that have none, sRGB."""

_UV_TYPES = ("texCoord2f[]", "texCoord2d[]", "texCoord2h[]", "float2[]")


@dataclass(frozen=True, eq=False)
class _Part:
    """A part of a prim that has one look; its triangles are given by their indices (m,)."""

    path: str
    rows: IntArray
    look: Look


class GprimReader:
    """Reads the prims of one stage that can be drawn: meshes and primitive shapes."""

    def __init__(self, materials: Materials, findings: Findings, values: Values) -> None:
        self._materials, self._findings, self._values = materials, findings, values

    def read(self, prim: Any) -> Iterator[SceneMesh]:
        """Yield the prim's meshes in its own space: none without faces, else one mesh or one for each geom subset."""
        topology = self._topology(prim)
        if topology is None or not len(topology.triangles):
            return
        normals = self._normals(prim, topology)
        for part in self._parts(prim, topology):
            yield self._mesh(prim, topology.chosen(part.rows), normals[part.rows], part)

    def _topology(self, prim: Any) -> Topology | None:
        kind = str(prim.GetTypeName())
        if prim.IsA(UsdGeom.Mesh):
            return self._faces(UsdGeom.Mesh(prim))
        if kind in SHAPES:
            return self._shape(prim, kind)
        self._findings.add(f"{kind} prims are not drawn", str(prim.GetPath()))
        return None

    def _shape(self, prim: Any, kind: str) -> Topology:
        """Return a shape such as a cube; a value of a wrong type is replaced by the default value of USD's schema."""
        definition = prim.GetPrimDefinition()

        def size(name: str) -> float:
            return self._values.number(prim.GetAttribute(name), float(definition.GetAttributeFallbackValue(name)))

        def axis() -> str:
            chosen = self._values.text(prim.GetAttribute("axis"), "Z")
            return chosen if chosen in AXES else "Z"

        return SHAPES[kind](size, axis)

    def _faces(self, mesh: Any) -> Topology | None:
        points = self._values.triples(mesh.GetPointsAttr())
        counts = self._values.indices(mesh.GetFaceVertexCountsAttr())
        indices = self._values.indices(mesh.GetFaceVertexIndicesAttr())
        holes = self._values.indices(mesh.GetHoleIndicesAttr())
        if points is None or counts is None or indices is None:
            return None
        if not _is_consistent(points, counts, indices):
            self._findings.add("Mesh with faces that do not fit its points", str(mesh.GetPath()))
            return None
        if self._values.text(mesh.GetSubdivisionSchemeAttr(), UsdGeom.Tokens.none) != UsdGeom.Tokens.none:
            self._findings.add("Subdivision surfaces are drawn without their subdivision", str(mesh.GetPath()))
        topology = triangulated(points, counts, indices, np.zeros(0, np.int64) if holes is None else holes)
        left_handed = self._values.text(mesh.GetOrientationAttr(), "") == UsdGeom.Tokens.leftHanded
        return topology.flipped() if left_handed else topology

    def _normals(self, prim: Any, topology: Topology) -> FloatArray:
        """Return the (m, 3, 3) normals of the triangles' corners, from the file or computed."""
        primvar = UsdGeom.PrimvarsAPI(prim).GetPrimvar("normals")
        authored = None
        if primvar and primvar.HasValue():
            authored = self._spread(primvar, topology)
        elif prim.IsA(UsdGeom.Mesh):
            mesh = UsdGeom.Mesh(prim)
            values = self._values.triples(mesh.GetNormalsAttr())
            if values is not None and len(values):
                authored = self._corners(values, mesh.GetNormalsInterpolation(), topology, f"{prim.GetPath()}.normals")
        if authored is None or authored.shape[-1] != 3:
            return corner_normals(topology.points, topology.triangles)
        lengths = np.linalg.norm(authored, axis=-1, keepdims=True)
        return np.asarray(authored / np.where(lengths == 0, 1, lengths))

    def _parts(self, prim: Any, topology: Topology) -> Iterator[_Part]:
        """Yield each geom subset with a material of its own, then all other faces."""
        path, rest = str(prim.GetPath()), np.ones(len(topology.faces), np.bool_)
        for subset in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets():
            faces = self._values.indices(subset.GetIndicesAttr())
            inside = np.isin(topology.faces, [] if faces is None else faces) & rest
            if inside.any():
                look = self._materials.look(subset.GetPrim())
                yield _Part(f"{path}/{subset.GetPrim().GetName()}", np.flatnonzero(inside), look)
            rest &= ~inside
        if rest.any():
            yield _Part(path, np.flatnonzero(rest), self._materials.look(prim))

    def _mesh(self, prim: Any, topology: Topology, normals: FloatArray, part: _Part) -> SceneMesh:
        look = part.look
        uvs = None if look.texture is None else self._uvs(prim, look, topology)
        if look.texture is not None and uvs is None:
            self._findings.add("Texture on a surface without texture coordinates", part.path)
            red, green, blue = (look.texture[..., :3].mean(axis=(0, 1)) / 255).tolist()
            look = replace(look, texture=None, colour=(red, green, blue))
        colour, colours = self._colour(prim, look, topology)
        columns: list[npt.NDArray[np.generic]] = [topology.triangles.reshape(-1, 1), _rows3(normals)]
        columns += [values.reshape(len(columns[0]), -1) for values in (uvs, colours) if values is not None]
        first, corners = weld(columns)
        points = topology.points[topology.triangles.reshape(-1)[first]]
        return SceneMesh(
            path=part.path,
            points=points,
            triangles=corners.reshape(-1, 3),
            normals=_rows3(normals)[first],
            uvs=None if uvs is None else uvs.reshape(-1, 2)[first],
            colour=colour,
            vertex_colours=None if colours is None else colours.reshape(-1, 3)[first],
            opacity=self._opacity(prim) if look.opacity is None else min(max(look.opacity, 0.0), 1.0),
            texture=look.texture,
            wrap=look.wrap,
            emissive=look.emissive,
        )

    def _uvs(self, prim: Any, look: Look, topology: Topology) -> FloatArray | None:
        primvar = self._uv_primvar(prim, look.uv_primvar)
        uvs = None if primvar is None else self._spread(primvar, topology)
        if uvs is None or uvs.shape[-1] != 2:
            return None
        return np.asarray(uvs @ look.uv_transform[:2] + look.uv_transform[2])

    def _uv_primvar(self, prim: Any, name: str | None) -> Any | None:
        api = UsdGeom.PrimvarsAPI(prim)
        if name is not None:
            named = api.FindPrimvarWithInheritance(name)
            if named and named.HasValue():
                return named
        primvars = [primvar for primvar in api.FindPrimvarsWithInheritance() if str(primvar.GetTypeName()) in _UV_TYPES]
        return min(
            primvars, key=lambda primvar: (primvar.GetPrimvarName() != "st", primvar.GetPrimvarName()), default=None
        )

    def _colour(self, prim: Any, look: Look, topology: Topology) -> tuple[Colour, UInt8Array | None]:
        """Return the surface's colour, and the (m, 3, 3) colours of the triangles' corners or None."""
        if look.colour is not None:
            return look.colour, None
        primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance(look.colour_primvar)
        colours = self._spread(primvar, topology) if primvar and primvar.HasValue() else None
        if colours is None or colours.shape[-1] != 3:
            return GREY, None
        shown = to_srgb(colours)
        if (shown == shown[0, 0]).all():
            red, green, blue = shown[0, 0].tolist()
            return (red, green, blue), None
        return (1.0, 1.0, 1.0), np.round(shown * 255).astype(np.uint8)

    def _opacity(self, prim: Any) -> float:
        primvar = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayOpacity")
        values = self._values.flattened(primvar) if primvar and primvar.HasValue() else None
        return 1.0 if values is None or not values.size else float(np.clip(values.mean(), 0, 1))

    def _spread(self, primvar: Any, topology: Topology) -> FloatArray | None:
        values = self._values.flattened(primvar)
        if values is None:
            return None
        return self._corners(values, primvar.GetInterpolation(), topology, str(primvar.GetAttr().GetPath()))

    def _corners(self, values: FloatArray, interpolation: str, topology: Topology, path: str) -> FloatArray | None:
        """Return the values at the triangles' corners, (m, 3, k); None if there are too few values."""
        index = {
            UsdGeom.Tokens.constant: np.zeros_like(topology.corners),
            UsdGeom.Tokens.uniform: np.repeat(topology.faces[:, None], 3, axis=1),
            UsdGeom.Tokens.faceVarying: topology.corners,
        }.get(interpolation, topology.triangles)
        if not len(values) or index.max() >= len(values):
            self._findings.add("Too few values for the faces", path)
            return None
        return np.asarray(values[index])


def _is_consistent(points: FloatArray, counts: IntArray, indices: IntArray) -> bool:
    if not len(counts) and not len(indices):
        return True
    numbered = counts.min(initial=0) >= 0 and counts.max(initial=0) <= len(indices) == counts.sum()
    fits = numbered and (np.abs(points) <= LARGEST).all()
    return bool(fits and indices.min(initial=0) >= 0 and indices.max(initial=-1) < len(points))


def _rows3(values: FloatArray) -> FloatArray:
    """Return values as (c, 3), rounded to single precision so that equal corners compare equal."""
    return values.reshape(-1, 3).astype(np.float32).astype(np.float64)
