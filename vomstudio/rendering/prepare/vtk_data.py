"""Conversion of NumPy arrays to VTK data sets, which copy each array or keep it alive.

PyVista is not used here, because it is slower. Importing it takes 0.5 to 0.9 s after VTK
has been imported, and no picture can be drawn during this time. Creating a small data set
takes 0.13 ms instead of 0.03 to 0.06 ms, and a scene has thousands of them. A cloud of
500,000 points takes 0.4 ms instead of 0.03 ms, because each point becomes a cell, and a
texture of 2048 x 2048 pixels takes 30 to 80 ms instead of 0.1 ms. Only a mesh of a million
faces is faster (0.13 ms instead of 0.25 to 0.6 ms).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from vtkmodules.util import numpy_support
from vtkmodules.vtkCommonCore import VTK_INT, vtkDataArray, vtkPoints, vtkUnsignedCharArray
from vtkmodules.vtkCommonDataModel import (
    vtkCellArray,
    vtkImageData,
    vtkPlaneCollection,
    vtkPolyData,
)
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from vomstudio.core.arrays import (
    AnyArray,
    ByteArray,
    Float32Array,
    FloatArray,
    Int32Array,
    IntArray,
)

_DEPTH_STEP = 0.000016
"""Unit of VTK's offsets of coincident surfaces, as a share of the depth buffer."""

# VTK's helpers are untyped, because the type of the result depends on the argument.
numpy_to_vtk: Callable[..., Any] = numpy_support.numpy_to_vtk
_vtk_to_numpy: Callable[..., Any] = numpy_support.vtk_to_numpy


def to_array(values: vtkDataArray) -> AnyArray:
    """Return the values (n,) or (n, components) of a VTK array without copying them."""
    return np.asarray(_vtk_to_numpy(values))


def vtk_points(points: Float32Array) -> vtkPoints:
    """Return VTK points that share the memory of an array (n, 3) float32."""
    out = vtkPoints()
    out.SetData(numpy_to_vtk(np.ascontiguousarray(points, np.float32)))
    return out


def triangles(
    points: Float32Array,
    faces: Int32Array,
    *,
    uv: Float32Array | None = None,
    colors: ByteArray | None = None,
) -> vtkPolyData:
    """Create a triangle mesh from points (n, 3) and faces (m, 3) of point indices."""
    data = vtkPolyData()
    data.SetPoints(vtk_points(points))
    data.SetPolys(triangle_cells(faces))
    if uv is not None:
        array = numpy_to_vtk(np.ascontiguousarray(uv, np.float32))
        array.SetName("uv")
        data.GetPointData().SetTCoords(array)
    if colors is not None:
        set_colors(data, colors)
    return data


def triangle_cells(faces: Int32Array) -> vtkCellArray:
    """Convert triangles (m, 3), given as point indices, to VTK cells."""
    cells = vtkCellArray()
    flat_indices = np.ascontiguousarray(faces, np.int32).reshape(-1)
    offsets = np.arange(0, len(flat_indices) + 1, 3, dtype=np.int32)
    cells.SetData(
        numpy_to_vtk(offsets, array_type=VTK_INT), numpy_to_vtk(flat_indices, array_type=VTK_INT)
    )
    return cells


def point_set(points: Float32Array, colors: ByteArray | None = None) -> vtkPolyData:
    """Return points without cells, as required by vtkPointGaussianMapper."""
    data = vtkPolyData()
    data.SetPoints(vtk_points(points))
    if colors is not None:
        set_colors(data, colors)
    return data


def set_colors(data: vtkPolyData, colors: ByteArray) -> None:
    """Set RGB or RGBA point colours (n, 3 or 4) uint8 as the active scalars."""
    data.GetPointData().SetScalars(color_array(colors))


def color_array(colors: ByteArray) -> vtkUnsignedCharArray:
    """Copy colours to a VTK array."""
    array: vtkUnsignedCharArray = numpy_to_vtk(np.ascontiguousarray(colors, np.uint8))
    array.SetName("rgb")
    return array


def cells_of_sizes(sizes: Sequence[int] | IntArray) -> vtkCellArray:
    """Return cells of consecutive points with the given numbers of points per cell."""
    offsets = np.concatenate([[0], np.cumsum(np.asarray(sizes, np.int64))]).astype(np.int32)
    cells = vtkCellArray()
    cells.SetData(
        numpy_to_vtk(offsets, array_type=VTK_INT),
        numpy_to_vtk(np.arange(offsets[-1], dtype=np.int32), array_type=VTK_INT),
    )
    return cells


def uniform_cells(first: int, count: int, size: int) -> vtkCellArray:
    """Return `count` cells of `size` consecutive points each, starting at point `first`."""
    cells = vtkCellArray()
    offsets = np.arange(0, size * count + 1, size, dtype=np.int32)
    points = np.arange(first, first + size * count, dtype=np.int32)
    cells.SetData(
        numpy_to_vtk(offsets, array_type=VTK_INT), numpy_to_vtk(points, array_type=VTK_INT)
    )
    return cells


def show(actor: vtkActor, data: vtkPolyData) -> None:
    """Set the data of an actor that has a polygon mapper."""
    mapper = actor.GetMapper()
    assert isinstance(mapper, vtkPolyDataMapper)
    mapper.SetInputData(data)


def clip(actor: vtkActor, planes: vtkPlaneCollection | None) -> None:
    """Clip an actor to the inner side of planes; None removes the clipping."""
    if planes is None:
        actor.GetMapper().RemoveAllClippingPlanes()
    else:
        actor.GetMapper().SetClippingPlanes(planes)


def push_back(actor: vtkActor, offset: float) -> None:
    """Draw an actor as if it were farther from the viewer.

    Parameters
    ----------
    actor : vtkActor
    offset : float
        Increase of its depth-buffer values, which are between 0 and 1.
    """
    steps = offset / _DEPTH_STEP
    mapper = actor.GetMapper()
    mapper.SetRelativeCoincidentTopologyPolygonOffsetParameters(0.0, steps)
    mapper.SetRelativeCoincidentTopologyLineOffsetParameters(0.0, steps)
    mapper.SetRelativeCoincidentTopologyPointOffsetParameter(steps)


def image(pixels: ByteArray) -> vtkImageData:
    """Convert pixels (height, width, channels) uint8, bottom row first, to a VTK image."""
    height, width, channels = pixels.shape
    out = vtkImageData()
    out.SetDimensions(width, height, 1)
    out.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(pixels).reshape(-1, channels)))
    return out


def matrix(values: FloatArray) -> vtkMatrix4x4:
    """Copy a matrix (4, 4) to a VTK matrix."""
    out = vtkMatrix4x4()
    out.DeepCopy(np.asarray(values, np.float64).reshape(-1).tolist())
    return out


def rgb(color: tuple[float, float, float]) -> ByteArray:
    """Convert an RGB colour with components from 0 to 1 to (3,) uint8."""
    return np.asarray(np.round(np.clip(color, 0.0, 1.0) * np.array(255.0)), np.uint8)
