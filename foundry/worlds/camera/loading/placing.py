"""Puts meshes where they belong: transforms, copies, and one point for each distinct corner."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from foundry.worlds.camera.loading.scene import FloatArray, IntArray, SceneMesh

_Scalar = TypeVar("_Scalar", bound=np.generic)


def weld(columns: list[npt.NDArray[np.generic]]) -> tuple[IntArray, IntArray]:
    """Find the distinct corners among c of them.

    Args:
        columns: (c, k) values of each corner; corners that agree in all columns are one.

    Returns:
        For each distinct corner the first corner that is like it (n,), and for each corner its distinct one (c,).
    """
    bits = [np.ascontiguousarray(column, np.float64).view(np.uint64) for column in columns]
    # One 64-bit hash for each corner: sorting whole rows takes ten times as long on a million triangles.
    keys = np.zeros(len(columns[0]), np.uint64)
    for column in np.concatenate(bits, axis=1).T:
        keys = (keys ^ column) * np.uint64(0x9E3779B97F4A7C15)
        keys ^= keys >> np.uint64(29)
    _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
    return first.astype(np.int64), inverse.astype(np.int64)


def placed(mesh: SceneMesh, matrices: FloatArray) -> SceneMesh:
    """Return the mesh under each of these (k, 4, 4) transforms (points are rows), as one mesh."""
    linear, count = matrices[:, :3, :3], len(mesh.points)
    with np.errstate(all="ignore"):  # a file may place things nowhere; who loads it leaves them out
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
    """Transform (n, 3) normals by the cofactors, which exist even where a scale is 0 and no inverse does."""
    cofactors = np.cross(np.roll(linear, -1, axis=1), np.roll(linear, -2, axis=1))
    signs = np.where(mirrored, -1.0, 1.0)[:, None, None]
    turned = (normals @ cofactors * signs).reshape(-1, 3)
    lengths = np.linalg.norm(turned, axis=1, keepdims=True)
    return np.asarray(turned / np.where(lengths == 0, 1, lengths))


def _repeated(values: npt.NDArray[_Scalar] | None, times: int) -> npt.NDArray[_Scalar] | None:
    return None if values is None else np.tile(values, (times, 1))
