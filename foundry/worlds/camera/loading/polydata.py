"""Between numpy arrays and VTK's polygon data."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from vtkmodules.util import numpy_support
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals

from foundry.worlds.camera.loading.scene import FloatArray, IntArray, UInt8Array

_support: Any = numpy_support

FEATURE_ANGLE = 30.0
"""Degrees between two faces above which their edge looks sharp."""


def polydata(points: FloatArray, triangles: IntArray) -> Any:
    """Return a vtkPolyData of (n, 3) points and (m, 3) triangles; it holds copies."""
    corners = vtk_points(points)
    cells = vtkCellArray()
    cells.SetData(3, _support.numpy_to_vtkIdTypeArray(np.ascontiguousarray(triangles, np.int64).ravel(), deep=True))
    data = vtkPolyData()
    data.SetPoints(corners)
    data.SetPolys(cells)
    return data


def vtk_points(points: FloatArray) -> Any:
    """Return (n, 3) points as vtkPoints of single precision."""
    corners = vtkPoints()
    corners.SetData(floats(points))
    return corners


def floats(values: FloatArray) -> Any:
    """Return (n, k) values as a VTK array of single precision."""
    return _support.numpy_to_vtk(np.ascontiguousarray(values, np.float32), deep=True)


def byte_values(values: UInt8Array) -> Any:
    """Return (n, k) bytes as a VTK array."""
    return _support.numpy_to_vtk(np.ascontiguousarray(values), deep=True)


def as_numpy(array: Any) -> npt.NDArray[Any]:
    """Return the values of a VTK array, not a copy."""
    return np.asarray(_support.vtk_to_numpy(array))


def triangles_of(data: Any) -> IntArray:
    """Return the (m, 3) triangles of a vtkPolyData that holds nothing else."""
    return as_numpy(data.GetPolys().GetConnectivityArray()).astype(np.int64).reshape(-1, 3)


def corner_normals(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Return (m, 3, 3) normals at the corners of the triangles: smooth, but split at sharp edges."""
    normals = vtkPolyDataNormals()
    normals.SetInputData(polydata(points, triangles))
    normals.SetFeatureAngle(FEATURE_ANGLE)
    normals.ConsistencyOff()
    normals.SplittingOn()
    normals.Update()
    out = normals.GetOutput()
    values = as_numpy(out.GetPointData().GetNormals())
    return np.asarray(values[triangles_of(out)], np.float64)
