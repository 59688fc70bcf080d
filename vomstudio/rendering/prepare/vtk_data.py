"""numpy arrays as VTK data sets; each array is a private copy or kept alive by VTK.

PyVista is not used, because it is slower here. Its import takes 0.5 to 0.9 s after that of VTK,
during which no picture can be drawn. A small data set takes 0.13 ms instead of 0.03 to 0.06,
and a scene has thousands; a cloud of 500,000 points 0.4 ms instead of 0.03, since each point
becomes a cell; a texture of 2048 x 2048 pixels 30 to 80 ms instead of 0.1. Only a mesh of a
million faces is faster, 0.13 ms instead of 0.25 to 0.6.
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

# VTK's helpers have no types: the type of the result depends on the argument.
numpy_to_vtk: Callable[..., Any] = numpy_support.numpy_to_vtk
_vtk_to_numpy: Callable[..., Any] = numpy_support.vtk_to_numpy


def to_array(values: vtkDataArray) -> AnyArray:
    """Return the values of a VTK array without a copy: (n,) or (n, components)."""
    return np.asarray(_vtk_to_numpy(values))


def vtk_points(points: Float32Array) -> vtkPoints:
    """Return points (n, 3) float32 that share the array."""
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
    """Return a triangle mesh; faces (m, 3) are rows of points (n, 3)."""
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
    """Return triangles (m, 3), which are rows of points, as cells."""
    cells = vtkCellArray()
    flat = np.ascontiguousarray(faces, np.int32).reshape(-1)
    offsets = np.arange(0, len(flat) + 1, 3, dtype=np.int32)
    cells.SetData(numpy_to_vtk(offsets, array_type=VTK_INT), numpy_to_vtk(flat, array_type=VTK_INT))
    return cells


def point_set(points: Float32Array, colors: ByteArray | None = None) -> vtkPolyData:
    """Return points without cells, as vtkPointGaussianMapper draws them."""
    data = vtkPolyData()
    data.SetPoints(vtk_points(points))
    if colors is not None:
        set_colors(data, colors)
    return data


def set_colors(data: vtkPolyData, colors: ByteArray) -> None:
    """Set RGB or RGBA (n, 3 or 4) uint8 per point as the active scalars."""
    data.GetPointData().SetScalars(color_array(colors))


def color_array(colors: ByteArray) -> vtkUnsignedCharArray:
    """Copy colours to an array of VTK."""
    array: vtkUnsignedCharArray = numpy_to_vtk(np.ascontiguousarray(colors, np.uint8))
    array.SetName("rgb")
    return array


def cells_of_sizes(sizes: Sequence[int] | IntArray) -> vtkCellArray:
    """Return cells of consecutive points, with the given numbers of points."""
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
    """Set the data of an actor whose mapper is one of polygons."""
    mapper = actor.GetMapper()
    assert isinstance(mapper, vtkPolyDataMapper)
    mapper.SetInputData(data)


def clip(actor: vtkActor, planes: vtkPlaneCollection | None) -> None:
    """Draw only the inner side of all these planes; None for everything."""
    if planes is None:
        actor.GetMapper().RemoveAllClippingPlanes()
    else:
        actor.GetMapper().SetClippingPlanes(planes)


def image(pixels: ByteArray) -> vtkImageData:
    """Return pixels (height, width, channels) uint8, first row at the bottom, as a VTK image."""
    height, width, channels = pixels.shape
    out = vtkImageData()
    out.SetDimensions(width, height, 1)
    out.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(pixels).reshape(-1, channels)))
    return out


def matrix(values: FloatArray) -> vtkMatrix4x4:
    """Copy a matrix (4, 4) to VTK."""
    out = vtkMatrix4x4()
    out.DeepCopy(np.asarray(values, np.float64).reshape(-1).tolist())
    return out


def rgb(color: tuple[float, float, float]) -> ByteArray:
    """Return RGB 0..1 as (3,) uint8."""
    return np.asarray(np.round(np.clip(color, 0.0, 1.0) * np.array(255.0)), np.uint8)
