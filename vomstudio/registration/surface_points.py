"""Points that represent a model.

These are the points of a cloud, or the vertices of a mesh with additional points on large faces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import weld_points
from vomstudio.geometry.mesh import Mesh

_MAX_ADDED_POINTS = 20_000_000
_MAX_EXTENT_POINTS = 20_000


def points_of(data: Mesh | PointCloud) -> FloatArray:
    """Return all points of a model, including duplicates.

    Parameters
    ----------
    data : Mesh or PointCloud

    Returns
    -------
    (n, 3) ndarray
        Points in the file frame.
    """
    return data.vertices if isinstance(data, Mesh) else data.points


def sample_points(data: Mesh | PointCloud) -> FloatArray:
    """Return enough finite points, distributed over the model, to represent its extent.

    Parameters
    ----------
    data : Mesh or PointCloud

    Returns
    -------
    (n, 3) ndarray
    """
    points = points_of(data)
    sample = np.asarray(points[:: max(1, len(points) // _MAX_EXTENT_POINTS)], np.float64)
    return sample[np.isfinite(sample).all(axis=1)]


def known_resolution(data: Mesh | PointCloud) -> float | None:
    """Return the effective resolution of a model.

    Parameters
    ----------
    data : Mesh or PointCloud

    Returns
    -------
    float or None
        Resolution in the unit of the file, or None for a single point.
    """
    from vomstudio.io.models.opening import resolution

    spacing = resolution(data)
    return spacing if np.isfinite(spacing) else None


def surface_points(
    data: Mesh | PointCloud, spacing: float, seed: int = 0
) -> tuple[FloatArray, int]:
    """Return the points of a surface without duplicates.

    Parameters
    ----------
    data : Mesh or PointCloud
    spacing : float
        Side of a square; faces that are larger than the square receive random points, on average
        one per square.
    seed : int

    Returns
    -------
    points : (n, 3) array
        Finite points.
    added : int
        Number of points added on faces.
    """
    positions = np.asarray(points_of(data), np.float64)
    if not isinstance(data, Mesh) or not len(data.faces):
        return positions[np.isfinite(positions).all(axis=1)], 0
    corners = [positions[data.faces[:, k]] for k in range(3)]
    area = np.linalg.norm(np.cross(corners[1] - corners[0], corners[2] - corners[0]), axis=1) / 2
    point_ids = weld_points(positions)
    is_first = np.zeros(len(positions), bool)
    is_first[np.unique(point_ids, return_index=True)[1]] = True
    is_first &= np.isfinite(positions).all(axis=1)
    # Exclude vertices that no face uses.
    is_used = np.zeros(int(point_ids.max(initial=-1)) + 1, bool)
    is_used[point_ids[data.faces.ravel()]] = True
    is_first &= is_used[point_ids]
    point_counts = np.where(np.isfinite(area) & (area > spacing**2), area / spacing**2, 0.0)
    if point_counts.sum() > _MAX_ADDED_POINTS:
        point_counts *= _MAX_ADDED_POINTS / point_counts.sum()
    rng = np.random.default_rng(seed)
    counts = np.floor(point_counts + rng.random(len(point_counts))).astype(np.int64) * (
        point_counts > 0
    )
    face = np.repeat(np.arange(len(point_counts)), counts)
    # Osada et al. 2002, ACM Transactions on Graphics 21, 807.
    root, fraction = np.sqrt(rng.random(len(face)))[:, None], rng.random(len(face))[:, None]
    a, b, c = (corner[face] for corner in corners)
    points = (1.0 - root) * a + root * (1.0 - fraction) * b + root * fraction * c
    return np.concatenate([positions[is_first], points]), len(points)


@dataclass(frozen=True, eq=False)
class Counterparts:
    """Counterparts of points on a benchmark.

    Attributes
    ----------
    distance : (n,) array
        Signed distance, positive on the side of the benchmark normals; NaN for non-finite points.
    distance_beyond_edge : (n,) array
        Distance beyond the edge of the benchmark, along its surface.
    normal : (n, 3) array
        Unit normals of the benchmark.
    """

    distance: FloatArray
    distance_beyond_edge: FloatArray
    normal: FloatArray
