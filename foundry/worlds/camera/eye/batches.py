"""Meshes that look alike as one: a scene of a thousand prims is drawn in a few calls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from foundry.worlds.camera.eye.canvas import actor, vtk_texture
from foundry.worlds.camera.loading.polydata import byte_values, corner_normals, floats, polydata
from foundry.worlds.camera.loading.scene import FloatArray, SceneMesh, UInt8Array

LEAST_OPACITY = 0.5
"""A surface that lets more light through does not hide what is behind it."""


def scene_actors(meshes: Sequence[SceneMesh], *, fade: float = 1.0) -> list[Any]:
    """Return the actors that show the meshes, the opaque ones first; their opacity is multiplied by `fade`."""
    batches: dict[tuple[object, ...], list[SceneMesh]] = {}
    for mesh in meshes:
        key = (mesh.opacity, id(mesh.texture), mesh.wrap)
        batches.setdefault(key, []).append(mesh)
    shown = [batch for batch in batches.values() if batch[0].opacity > 0]
    opaque_first = sorted(shown, key=lambda batch: -batch[0].opacity)
    return [_batch_actor([with_normals(mesh) for mesh in batch], fade) for batch in opaque_first]


def id_actor(meshes: Sequence[SceneMesh]) -> Any:
    """Return one actor in which each mesh has a flat colour of its own: its place in the sequence plus 1."""
    hiding = [(number + 1, mesh) for number, mesh in enumerate(meshes) if mesh.opacity >= LEAST_OPACITY]
    if not hiding:
        return actor(polydata(np.zeros((0, 3)), np.zeros((0, 3), np.int64)))
    data = _joined([mesh for _, mesh in hiding])
    colours = [np.tile(_id_colour(number), (len(mesh.triangles), 1)) for number, mesh in hiding]
    data.GetCellData().SetScalars(byte_values(np.concatenate(colours)))
    return actor(data)


def ids_of(image: UInt8Array) -> npt.NDArray[np.int64]:
    """Return the (h, w) ids that a picture of `id_actor` shows; 0 where there is nothing."""
    return np.asarray(image.astype(np.int64) @ np.array([65536, 256, 1]))


def with_normals(mesh: SceneMesh) -> SceneMesh:
    """Return the mesh itself, or one with made normals when it has none."""
    if mesh.normals is not None:
        return mesh
    corners = mesh.triangles.ravel()
    return replace(
        mesh,
        points=mesh.points[corners],
        triangles=np.arange(len(corners)).reshape(-1, 3),
        normals=corner_normals(mesh.points, mesh.triangles).reshape(-1, 3),
        uvs=None if mesh.uvs is None else mesh.uvs[corners],
        vertex_colours=None if mesh.vertex_colours is None else mesh.vertex_colours[corners],
    )


def _batch_actor(meshes: Sequence[SceneMesh], fade: float) -> Any:
    first = meshes[0]
    data = _joined(meshes)
    values = data.GetPointData()
    values.SetScalars(byte_values(np.concatenate([lit_colours(mesh) for mesh in meshes])))
    made = actor(data, opacity=first.opacity * fade)
    if first.texture is not None:
        blank = (np.zeros((len(mesh.points), 2)) if mesh.uvs is None else mesh.uvs for mesh in meshes)
        values.SetTCoords(floats(np.concatenate(list(blank))))
        made.SetTexture(vtk_texture(first.texture, first.wrap))
    return made


def _joined(meshes: Sequence[SceneMesh]) -> Any:
    starts = np.cumsum([0, *(len(mesh.points) for mesh in meshes[:-1])])
    triangles = [mesh.triangles + start for mesh, start in zip(meshes, starts, strict=True)]
    return polydata(np.concatenate([mesh.points for mesh in meshes]), np.concatenate(triangles))


def lit_colours(mesh: SceneMesh) -> UInt8Array:
    """Return the (n, 3) colours of the points as they are lit; what shines adds its own light."""
    assert mesh.normals is not None
    own: FloatArray = np.array([mesh.colour]) if mesh.vertex_colours is None else mesh.vertex_colours / 255.0
    shown: FloatArray = np.clip(own * brightness(mesh.normals)[:, None] + np.array(mesh.emissive), 0, 1)
    return np.round(shown * 255).astype(np.uint8)


def _id_colour(number: int) -> UInt8Array:
    return np.array([number >> 16 & 255, number >> 8 & 255, number & 255], np.uint8)


_AMBIENT = 0.6
"""What every surface gets from everywhere, of 1."""

_LIGHTS = np.array([[0.32, 0.18, 0.25], [0.02, 0.10, 0.40]])
"""What comes from +X, +Y, +Z and from -X, -Y, -Z: the six sides of a room are six shades of one colour."""


def brightness(normals: FloatArray) -> FloatArray:
    """Return (n,) how bright surfaces are that face along these (n, 3) unit vectors; at most 1.

    It is worked out once for every point of a scene: a picture takes a third less time than with lights of VTK's.
    """
    lit = np.clip(normals, 0, None) @ _LIGHTS[0] + np.clip(-normals, 0, None) @ _LIGHTS[1]
    return np.asarray(np.minimum(_AMBIENT + lit, 1.0))
