"""A part of a model as a model of its own."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.words import tr


def piece_of(data: Mesh | PointCloud, mask: npt.NDArray[np.bool_]) -> Mesh | PointCloud:
    """The faces of a mesh with the vertices and materials that they use, or the points of a cloud,
    with all their values, in the file's frame. mask : (n,) which. Raises GeometryError where that is
    none, or the mask is of another model."""
    count = len(data.faces) if isinstance(data, Mesh) else len(data.points)
    if len(mask) != count:
        raise GeometryError(
            tr("{given} were chosen from a model of {count}.", given=len(mask), count=count)
        )
    if not mask.any():
        raise GeometryError(tr("Nothing is chosen."))
    return _faces_of(data, mask) if isinstance(data, Mesh) else data.of_rows(mask)


def _faces_of(mesh: Mesh, mask: npt.NDArray[np.bool_]) -> Mesh:
    chosen = np.flatnonzero(mask)
    faces = np.asarray(mesh.faces)[chosen]
    used = np.zeros(len(mesh.vertices), np.bool_)
    used[faces.ravel()] = True
    rows = np.flatnonzero(used)
    number = np.empty(len(used), np.int32)
    number[rows] = np.arange(len(rows), dtype=np.int32)
    offsets = np.searchsorted(chosen, np.asarray(mesh.material_offsets, np.int64))
    worn = np.flatnonzero(np.diff(offsets) > 0) if mesh.materials else np.zeros(0, np.int64)
    return Mesh(
        np.asarray(mesh.vertices)[rows],
        number[faces],
        tuple(mesh.materials[i] for i in worn),
        # Materials without a face left are dropped; the runs of the others follow one another.
        np.append(offsets[worn], offsets[worn[-1] + 1]) if len(worn) else np.zeros(1, np.int64),
        None if mesh.uv is None else np.asarray(mesh.uv)[rows],
        None if mesh.colors is None else np.asarray(mesh.colors)[rows],
        {name: np.asarray(values)[rows] for name, values in mesh.fields.items()},
    )
