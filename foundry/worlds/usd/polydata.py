"""Between numpy arrays and VTK's polygon data."""

from __future__ import annotations

from typing import Any

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals

from foundry.worlds.usd.scene import FloatArray, IntArray

FEATURE_ANGLE = 30.0
"""Degrees between two faces above which their edge looks sharp."""


def polydata(points: FloatArray, triangles: IntArray) -> Any:
    """Return a vtkPolyData of (n, 3) points and (m, 3) triangles; it holds copies."""
    corners = vtk_points(points)
    cells = vtkCellArray()
    cells.SetData(3, numpy_to_vtkIdTypeArray(np.ascontiguousarray(triangles, np.int64).ravel(), deep=True))
    data = vtkPolyData()
    data.SetPoints(corners)
    data.SetPolys(cells)
    return data


def vtk_points(points: FloatArray) -> Any:
    """Return (n, 3) points as vtkPoints of single precision."""
    corners = vtkPoints()
    corners.SetData(numpy_to_vtk(np.ascontiguousarray(points, np.float32), deep=True))
    return corners


def triangles_of(data: Any) -> IntArray:
    """Return the (m, 3) triangles of a vtkPolyData that holds nothing else."""
    return np.asarray(vtk_to_numpy(data.GetPolys().GetConnectivityArray()), np.int64).reshape(-1, 3)


def corner_normals(points: FloatArray, triangles: IntArray) -> FloatArray:
    """Return (m, 3, 3) normals at the corners of the triangles: smooth, but split at sharp edges."""
    normals = vtkPolyDataNormals()
    normals.SetInputData(polydata(points, triangles))
    normals.SetFeatureAngle(FEATURE_ANGLE)
    normals.ConsistencyOff()
    normals.SplittingOn()
    normals.Update()
    out = normals.GetOutput()
    values = vtk_to_numpy(out.GetPointData().GetNormals())
    return np.asarray(values[triangles_of(out)], np.float64)
