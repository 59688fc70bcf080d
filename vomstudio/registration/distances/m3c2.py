"""Distances between clouds along local normals, with a level of detection from roughness.

M3C2 follows Lague, Brodu & Leroux 2013 (ISPRS J. Photogramm. Remote Sens. 82, 10). A normal is
estimated at one scale around each core point. A cylinder at another scale along the normal contains
points of each cloud. The distance is the distance between the means of the two clouds in the
cylinder, and the level of detection (95 %) is 1.96 (sqrt(s1^2 / n1 + s2^2 / n2) + reg).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.geometry.nearby.point_grid import PointGrid

Z95 = 1.96
"""Factor of the 95 % level of detection, as published."""
NORMAL_SCALE = 2.0
"""Radius of the ball used to estimate a normal, in radii of the cylinder."""
MIN_POINTS = 5
"""Minimum number of points of each cloud for a standard deviation."""


@dataclass(frozen=True, eq=False)
class Projection:
    """Result of `project`.

    Attributes
    ----------
    distance : (n,) array
        Distance, first cloud minus second, along the normal; NaN if either cloud has no point in
        the cylinder.
    lod95 : (n,) array
        Level of detection; NaN if either cloud has fewer than MIN_POINTS points.
    normal : (n, 3) array
    count : (n, 2) array
        Number of points of each cloud in the cylinder.
    """

    distance: FloatArray
    lod95: FloatArray
    normal: FloatArray
    count: IntArray


def normals_at(
    cloud: FloatArray,
    positions: FloatArray,
    radius: float,
    reference_normals: FloatArray,
    progress: Progress | None = None,
) -> FloatArray:
    """Compute unit normals of a cloud.

    Parameters
    ----------
    cloud : (m, 3) array
    positions : (n, 3) array
    radius : float
        Radius of the ball of points used to estimate a normal.
    reference_normals : (n, 3) array
        Vectors towards whose side the normals are oriented.
    progress : Progress, optional

    Returns
    -------
    (n, 3) array
        Unit normals, NaN for fewer than three points.
    """
    normals = PointGrid(cloud, radius).planes(positions, radius, progress).normal
    signs = np.where(np.einsum("ij,ij->i", normals, reference_normals) < 0, -1.0, 1.0)
    return np.asarray(normals * signs[:, None], np.float64)


def project(
    core_points: FloatArray,
    normals: FloatArray,
    first: FloatArray,
    second: FloatArray,
    *,
    radius: float,
    max_distance: float,
    registration_error: float = 0.0,
    progress: Progress | None = None,
) -> Projection:
    """Compute distances between two clouds along normals at core points.

    Parameters
    ----------
    core_points, normals : (n, 3) array
        Core points and unit normals.
    first, second : (k, 3) and (l, 3) array
        Clouds in the same frame and unit.
    radius : float
        Radius of the cylinder.
    max_distance : float
        Half length of the cylinder.
    registration_error : float
        One-sigma error of the relative position of the clouds.
    progress : Progress, optional
        Progress indicator, which may raise Cancelled.
    """
    progress = progress or SilentProgress()
    sums = []
    for title, cloud in ((tr("Model"), first), (tr("Benchmark"), second)):
        progress.stage(title, len(core_points))
        grid = PointGrid(cloud, radius)
        sums.append(grid.along(core_points, normals, radius, max_distance, progress))
    a, b = sums
    count = np.column_stack([a.count, b.count])
    with np.errstate(divide="ignore", invalid="ignore"):
        standard_error = np.sqrt(a.deviation**2 / a.count + b.deviation**2 / b.count)
    lod95 = Z95 * (standard_error + registration_error)
    lod95[(count < MIN_POINTS).any(axis=1)] = np.nan
    return Projection(a.mean - b.mean, lod95, normals, count)
