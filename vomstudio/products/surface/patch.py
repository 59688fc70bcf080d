"""The part of a model that is looked at as a surface."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.core.findings import Finding
from vomstudio.errors import InputError, UsageError
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

FACET = "facet"


def around(data: Mesh | PointCloud, centre: Array, radius: float) -> Mesh | PointCloud:
    """Faces with all corners, or points, within a radius of a place. Raises InputError where there
    are none."""
    points = data.vertices if isinstance(data, Mesh) else data.points
    near = np.asarray(np.linalg.norm(points - centre, axis=1) <= radius)
    return _where(data, near, Finding("patch.empty"))


def of_facet(data: Mesh | PointCloud, number: int) -> Mesh | PointCloud:
    """Those of a facet of a model that `facets --labels` wrote. Raises InputError where the model
    has no such field, or no such facet."""
    if FACET not in data.fields:
        raise InputError(Finding("facet.no-field"), field="--facet")
    own = np.asarray(data.fields[FACET]) == number
    return _where(data, own, Finding("facet.missing", number=number))


def of_faces(mesh: Mesh, faces: Ints) -> Mesh:
    """These faces (k,) alone, with what their vertices carry but without pictures."""
    corners = np.asarray(mesh.faces)[faces]
    ids, which = np.unique(corners, return_inverse=True)
    return Mesh(
        np.asarray(mesh.vertices[ids], np.float64),
        which.reshape(-1, 3).astype(np.int32),
        colors=None if mesh.colors is None else mesh.colors[ids],
        fields={name: np.asarray(values)[ids] for name, values in mesh.fields.items()},
    )


def parse_around(text: str) -> tuple[Array, float]:
    """Place (3,) and radius of "x,y,z,r". Raises UsageError."""
    try:
        found = np.array([float(word) for word in text.replace(";", ",").split(",")])
    except ValueError:
        found = np.empty(0)
    if found.shape != (4,) or not np.isfinite(found).all() or not found[3] > 0.0:
        raise UsageError(Finding("patch.not-a-place", text=text), field="--around")
    return found[:3], float(found[3])


def _where(
    data: Mesh | PointCloud, chosen: npt.NDArray[np.bool_], if_none: Finding
) -> Mesh | PointCloud:
    if isinstance(data, Mesh) and len(data.faces):
        faces = np.flatnonzero(chosen[data.faces].all(axis=1))
        if not len(faces):
            raise InputError(if_none)
        return of_faces(data, faces)
    if not chosen.any():
        raise InputError(if_none)
    if isinstance(data, Mesh):
        return PointCloud(np.asarray(data.vertices[chosen], np.float64))
    return data.of_rows(chosen)
