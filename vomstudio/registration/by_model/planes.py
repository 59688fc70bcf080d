"""Local planes of a model and of a reference, fitted within the same radius.

Both surfaces are smoothed equally, so the effect of edges and bends on the means cancels in the
difference, as in M3C2. It would not cancel between points and planes, because points lie in front
of planes at edges and behind them at notches.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.geometry.nearby.point_grid import LocalPlanes, PointGrid
from vomstudio.registration.similarity import Similarity

RADIUS = 4.0
"""Radius in resolutions of the coarser surface: contains some 50 points and exceeds their noise."""
_MIN_POINTS = 6
_MAX_OFFSET_RADII = 0.3
"""Maximum distance between two means along the surface, in radii."""
_MIN_NORMAL_COSINE = 0.7
"""Minimum cosine between two normals of the same face."""
_MAX_POINTS = 20_000


@dataclass(frozen=True, eq=False)
class PlaneMatches:
    """Positions of a model that lie on a reference.

    Attributes
    ----------
    places : (k, 3) array
        Positions in the World frame.
    residuals : (k,) array
        Distances along the normal, model minus reference, metres.
    normal : (k, 3) array
    normal_variance : (k,) array
        Variance of the normals in each direction due to the noise of their points, rad².
    """

    places: FloatArray
    residuals: FloatArray
    normal: FloatArray
    normal_variance: FloatArray


class ModelPlanes:
    """Local planes of a model, evenly distributed.

    Parameters
    ----------
    points : (n, 3) array
        Points in the model frame.
    radius : float
        Radius in the unit of the model.
    """

    def __init__(self, points: FloatArray, radius: float) -> None:
        grid = PointGrid(points, radius)
        # Unlike a single point, a mean lies on the surface.
        centres = grid.planes(thin_points(points, radius / 2.0), radius).mean
        planes = grid.planes(centres, radius)
        is_plane = _are_planar(planes)
        self.count = len(is_plane)
        self.centres = centres[is_plane]
        self.mean, self.normal = planes.mean[is_plane], planes.normal[is_plane]
        self.normal_variance = _normal_variances(planes)[is_plane]


class ReferencePlanes:
    """Local planes of a reference.

    Parameters
    ----------
    points : (n, 3) array
        Points in the World frame.
    radius : float
        Radius, metres.
    """

    def __init__(self, points: FloatArray, radius: float) -> None:
        self.radius = radius
        self._grid = PointGrid(points, radius)

    def match(self, model_planes: ModelPlanes, fit: Similarity) -> PlaneMatches:
        """Return the positions of a model that lie on the reference after a similarity."""
        placed_points = fit(model_planes.mean)
        # Use the same centres; otherwise the rim of the model would be compared with its interior.
        planes = self._grid.planes(fit(model_planes.centres), self.radius)
        model_normals = model_planes.normal @ fit.rotation.T
        signs = np.where(np.einsum("ij,ij->i", model_normals, planes.normal) < 0, -1.0, 1.0)
        mean = model_normals + signs[:, None] * planes.normal
        size = np.linalg.norm(mean, axis=1)
        with np.errstate(invalid="ignore"):
            normal = mean / size[:, None]
            offset = placed_points - planes.mean
            misclosures = np.einsum("ij,ij->i", offset, normal)
            squared_offset = np.einsum("ij,ij->i", offset, offset) - misclosures**2
            # The length of the mean of two unit vectors is the cosine of half their angle.
            is_parallel = size / 2.0 > np.sqrt((1.0 + _MIN_NORMAL_COSINE) / 2.0)
            is_match = (
                _are_planar(planes)
                & is_parallel
                & (squared_offset <= (_MAX_OFFSET_RADII * self.radius) ** 2)
            )
        # Variance of the mean of two normals.
        normal_variance = (model_planes.normal_variance + _normal_variances(planes)) / 4.0
        return PlaneMatches(
            placed_points[is_match],
            misclosures[is_match],
            normal[is_match],
            normal_variance[is_match],
        )


def _are_planar(planes: LocalPlanes) -> BoolArray:
    is_flat = planes.spread[:, 1] > 1e-6 * planes.spread[:, 2]
    return np.asarray((planes.count >= _MIN_POINTS) & is_flat, np.bool_)


def _normal_variances(planes: LocalPlanes) -> FloatArray:
    """Return the mean variance (k,) of the normals of planes, in rad².

    For n points with variances l0 across the plane and l1 and l2 along it, the variances of the
    normal are l0 / (n l1) and l0 / (n l2).
    """
    l0, l1, l2 = np.maximum(planes.spread, 0.0).T
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(l0 / np.maximum(planes.count - 3, 1) * (1 / l1 + 1 / l2) / 2, np.float64)


def thin_points(points: FloatArray, cell: float, max_points: int = _MAX_POINTS) -> FloatArray:
    """Thin points to one per grid cell, so that the point density has no influence.

    Parameters
    ----------
    points : (n, 3) ndarray
    cell : float
        Side length of a cell, which is increased if more than `max_points` points remain.
    max_points : int, optional

    Returns
    -------
    (m, 3) ndarray
    """
    local_points = points - points.min(axis=0)
    order = np.random.default_rng(0).permutation(len(points))
    while True:
        cells = np.floor(local_points / cell).astype(np.int64)
        width = cells.max(axis=0) + 1
        keys = cells[:, 0] + width[0] * (cells[:, 1] + width[1] * cells[:, 2])
        first_rows = np.unique(keys[order], return_index=True)[1]
        if len(first_rows) <= max_points:
            return points[np.sort(order[first_rows])]
        cell *= max(1.1, 0.95 * np.sqrt(len(first_rows) / max_points))
