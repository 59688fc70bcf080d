"""Points that stand for a model: those of a cloud, the vertices of a mesh, more of large faces."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import welded
from vomstudio.geometry.mesh import Mesh

_MOST = 20_000_000
_FEW = 20_000


def points_of(data: Mesh | PointCloud) -> FloatArray:
    """(n, 3) as they stand in the file, those that stand twice too."""
    return data.vertices if isinstance(data, Mesh) else data.points


def some_points(data: Mesh | PointCloud) -> FloatArray:
    """(n, 3) finite ones, spread over all of it: enough to tell how far it reaches."""
    points = points_of(data)
    some = np.asarray(points[:: max(1, len(points) // _FEW)], np.float64)
    return some[np.isfinite(some).all(axis=1)]


def known_resolution(data: Mesh | PointCloud) -> float | None:
    """Return the effective resolution in the unit of the file; None for a single point."""
    from vomstudio.io.models.opening import resolution

    found = resolution(data)
    return found if np.isfinite(found) else None


def surface_points(
    data: Mesh | PointCloud, spacing: float, seed: int = 0
) -> tuple[FloatArray, int]:
    """(n, 3) finite points of the surface, each place once; and how many of them were put into
    faces that are larger than the square of `spacing`, evenly at random, on the average one for
    each such square."""
    places = np.asarray(points_of(data), np.float64)
    if not isinstance(data, Mesh) or not len(data.faces):
        return places[np.isfinite(places).all(axis=1)], 0
    corners = [places[data.faces[:, k]] for k in range(3)]
    area = np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0]), axis=1) / 2
    number = welded(places)
    once = np.zeros(len(places), bool)
    once[np.unique(number, return_index=True)[1]] = True
    once &= np.isfinite(places).all(axis=1)
    # Vertices that no face uses are no part of the surface.
    used = np.zeros(int(number.max(initial=-1)) + 1, bool)
    used[number[data.faces.ravel()]] = True
    once &= used[number]
    large = np.where(np.isfinite(area) & (area > spacing**2), area / spacing**2, 0.0)
    if large.sum() > _MOST:
        large *= _MOST / large.sum()
    rng = np.random.default_rng(seed)
    counts = np.floor(large + rng.random(len(large))).astype(np.int64) * (large > 0)
    face = np.repeat(np.arange(len(large)), counts)
    # Osada et al. 2002, ACM Transactions on Graphics 21, 807.
    root, share = np.sqrt(rng.random(len(face)))[:, None], rng.random(len(face))[:, None]
    a, b, c = (corner[face] for corner in corners)
    inside = (1.0 - root) * a + root * (1.0 - share) * b + root * share * c
    return np.concatenate([places[once], inside]), len(inside)


@dataclass(frozen=True, eq=False)
class Opposite:
    """What of a benchmark lies opposite the points of a model.

    distance : (n,) signed, positive on the side to which the benchmark's normals point; NaN of
        places that are not finite
    beside : (n,) how far beyond the benchmark's edge a place lies, along its surface
    normal : (n, 3) unit normals of the benchmark there
    """

    distance: FloatArray
    beside: FloatArray
    normal: FloatArray
