"""Distances between clouds along local normals, with what of them can be told from roughness.

M3C2 after Lague, Brodu & Leroux 2013 (ISPRS J. Photogramm. Remote Sens. 82, 10): around each core
point a normal at one scale, along it a cylinder at another, in the cylinder the mean of each cloud;
the distance is what lies between the means, the level of detection (95 %)
1.96 (sqrt(s1^2 / n1 + s2^2 / n2) + reg).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.words import tr
from vomstudio.geometry.nearby.point_grid import PointGrid

Z95 = 1.96
"""As published."""
NORMAL_SCALE = 2.0
"""Radius of the ball that gives a normal, in radii of the cylinder."""
FEWEST = 5
"""Points of each cloud below which a standard deviation tells nothing."""


@dataclass(frozen=True, eq=False)
class Projected:
    """distance : (n,) the first cloud less the second along the normal; NaN where either has no
        point in the cylinder
    lod95 : (n,) below which a distance is none; NaN where either cloud has fewer than FEWEST points
    normal : (n, 3); count : (n, 2) points of each cloud in the cylinder
    """

    distance: FloatArray
    lod95: FloatArray
    normal: FloatArray
    count: IntArray


def normals_at(
    cloud: FloatArray,
    places: FloatArray,
    radius: float,
    sides: FloatArray,
    progress: Progress | None = None,
) -> FloatArray:
    """(n, 3) unit normals of a cloud (m, 3) at places (n, 3), by the points within `radius`, turned
    to the side of the vectors `sides` (n, 3); NaN where there are fewer than three points."""
    found = PointGrid(cloud, radius).planes(places, radius, progress).normal
    signs = np.where(np.einsum("ij,ij->i", found, sides) < 0, -1.0, 1.0)
    return np.asarray(found * signs[:, None], np.float64)


def project(
    core: FloatArray,
    normals: FloatArray,
    first: FloatArray,
    second: FloatArray,
    *,
    radius: float,
    reach: float,
    registration_error: float = 0.0,
    progress: Progress | None = None,
) -> Projected:
    """Distances at core points (n, 3) along unit normals (n, 3) between two clouds, (k, 3) and
    (l, 3), all in one frame and unit.

    radius : of the cylinder; reach : how far it goes to either side of the core point
    registration_error : one sigma of how the clouds are placed to each other
    Raises Cancelled through `progress`.
    """
    progress = progress or Silent()
    sums = []
    for title, cloud in ((tr("Model"), first), (tr("Benchmark"), second)):
        progress.stage(title, len(core))
        grid = PointGrid(cloud, radius)
        sums.append(grid.along(core, normals, radius, reach, progress))
    a, b = sums
    count = np.column_stack([a.count, b.count])
    with np.errstate(divide="ignore", invalid="ignore"):
        spread = np.sqrt(a.deviation**2 / a.count + b.deviation**2 / b.count)
    lod95 = Z95 * (spread + registration_error)
    lod95[(count < FEWEST).any(axis=1)] = np.nan
    return Projected(a.mean - b.mean, lod95, normals, count)
