"""Extraction of the part of a model that is analysed as a surface."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

FACET_FIELD = "facet"


def extract_within_radius(
    data: Mesh | PointCloud, centre: FloatArray, radius: float
) -> Mesh | PointCloud:
    """Extract the faces (with all corners) or points within a radius of a position.

    Raises
    ------
    InputError
        If the radius contains no complete face or no point.
    """
    points = data.vertices if isinstance(data, Mesh) else data.points
    is_near = np.asarray(np.linalg.norm(points - centre, axis=1) <= radius)
    return _extract(data, is_near, Finding("patch.empty"))


def extract_facet(data: Mesh | PointCloud, number: int) -> Mesh | PointCloud:
    """Extract the faces or points of a facet from a model written by `facets --labels`.

    Raises
    ------
    InputError
        If the model has no facet labels, or no complete face or point with this number.
    """
    if FACET_FIELD not in data.fields:
        raise InputError(Finding("facet.no-field"), field="--facet")
    selection = np.asarray(data.fields[FACET_FIELD]) == number
    return _extract(data, selection, Finding("facet.missing", number=number))


def extract_faces(mesh: Mesh, faces: IntArray) -> Mesh:
    """Extract the faces (k,) of a mesh, with colours and fields but without textures."""
    corners = np.asarray(mesh.faces)[faces]
    ids, inverse = np.unique(corners, return_inverse=True)
    return Mesh(
        np.asarray(mesh.vertices[ids], np.float64),
        inverse.reshape(-1, 3).astype(np.int32),
        colors=None if mesh.colors is None else mesh.colors[ids],
        fields={name: np.asarray(values)[ids] for name, values in mesh.fields.items()},
    )


def parse_around(text: str) -> tuple[FloatArray, float]:
    """Parse a position (3,) and a radius given as "x,y,z,r".

    Raises
    ------
    UsageError
    """
    try:
        values = np.array([float(word) for word in text.replace(";", ",").split(",")])
    except ValueError:
        values = np.empty(0)
    if values.shape != (4,) or not np.isfinite(values).all() or not values[3] > 0.0:
        raise UsageError(Finding("patch.not-a-place", text=text), field="--around")
    return values[:3], float(values[3])


def _extract(
    data: Mesh | PointCloud, selection: BoolArray, empty_finding: Finding
) -> Mesh | PointCloud:
    if isinstance(data, Mesh) and len(data.faces):
        faces = np.flatnonzero(selection[data.faces].all(axis=1))
        if not len(faces):
            raise InputError(empty_finding)
        return extract_faces(data, faces)
    if not selection.any():
        raise InputError(empty_finding)
    if isinstance(data, Mesh):
        return PointCloud(np.asarray(data.vertices[selection], np.float64))
    return data.select_rows(selection)
