"""Places of a model and of a reference as the means and planes of their points within one radius.

Both are smoothed alike, so that what edges and bends do to such a mean falls out of the difference,
as with M3C2. Points held against planes are not: they lie before each edge and behind each notch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.geometry.nearby.point_grid import LocalPlanes, PointGrid
from vomstudio.registration.similarity import Similarity

RADIUS = 4.0
"""In resolutions of the coarser of the two: some fifty points, and their noise well inside."""
_FEWEST = 6
_ASIDE = 0.3
"""In radii: means that are farther apart along the surface are those of different pieces of it."""
_LIKE = 0.7
"""Cosine: normals that differ more belong to different faces."""
_MOST = 20_000


@dataclass(frozen=True, eq=False)
class Met:
    """What of a reference the places of a model lie on.

    places : (k, 3) World; miss : (k,) along the normal, model less reference; normal : (k, 3)
    tilt : (k,) variance of the normals, rad squared in each direction, by the noise of the points
        that made them
    """

    places: FloatArray
    miss: FloatArray
    normal: FloatArray
    tilt: FloatArray


class Places:
    """Places of a model that are spread evenly over it.

    points : (n, 3) of the model in its own frame; radius : in its unit
    """

    def __init__(self, points: FloatArray, radius: float) -> None:
        grid = PointGrid(points, radius)
        # A mean lies on the surface, which a single point does not.
        middles = grid.planes(thinned(points, radius / 2.0), radius).mean
        found = grid.planes(middles, radius)
        sound = _have_planes(found)
        self.count = len(sound)
        self.middle = middles[sound]
        self.mean, self.normal = found.mean[sound], found.normal[sound]
        self.tilt = _tilt(found)[sound]


class Reference:
    """points : (n, 3) World; radius : metres"""

    def __init__(self, points: FloatArray, radius: float) -> None:
        self.radius = radius
        self._grid = PointGrid(points, radius)

    def met(self, places: Places, fit: Similarity) -> Met:
        """Of the places of a model at a similarity, those that lie on it."""
        placed = fit(places.mean)
        # Around the same middle, or the rim of the model would be held against what lies within.
        found = self._grid.planes(fit(places.middle), self.radius)
        mine = places.normal @ fit.rotation.T
        signs = np.where(np.einsum("ij,ij->i", mine, found.normal) < 0, -1.0, 1.0)
        mean = mine + signs[:, None] * found.normal
        size = np.linalg.norm(mean, axis=1)
        with np.errstate(invalid="ignore"):
            normal = mean / size[:, None]
            off = placed - found.mean
            miss = np.einsum("ij,ij->i", off, normal)
            aside = np.einsum("ij,ij->i", off, off) - miss**2
            # The mean of two unit vectors is as long as the cosine of half of their angle.
            like = size / 2.0 > np.sqrt((1.0 + _LIKE) / 2.0)
            sound = _have_planes(found) & like & (aside <= (_ASIDE * self.radius) ** 2)
        # Of the mean of two normals.
        tilt = (places.tilt + _tilt(found)) / 4.0
        return Met(placed[sound], miss[sound], normal[sound], tilt[sound])


def _have_planes(found: LocalPlanes) -> BoolArray:
    flat = found.spread[:, 1] > 1e-6 * found.spread[:, 2]
    return np.asarray((found.count >= _FEWEST) & flat, np.bool_)


def _tilt(found: LocalPlanes) -> FloatArray:
    """(k,) Of a plane by n points with the variance l0 across it and l1, l2 along it: the normal's
    variances are l0 / n l1 and l0 / n l2, here their mean."""
    l0, l1, l2 = np.maximum(found.spread, 0.0).T
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(l0 / np.maximum(found.count - 3, 1) * (1 / l1 + 1 / l2) / 2, np.float64)


def thinned(points: FloatArray, cell: float, most: int = _MOST) -> FloatArray:
    """One of the points (n, 3) for each cell of a grid, of larger cells where these are too many:
    dense parts count no more than others."""
    local = points - points.min(axis=0)
    order = np.random.default_rng(0).permutation(len(points))
    while True:
        cells = np.floor(local / cell).astype(np.int64)
        wide = cells.max(axis=0) + 1
        keys = cells[:, 0] + wide[0] * (cells[:, 1] + wide[1] * cells[:, 2])
        first = np.unique(keys[order], return_index=True)[1]
        if len(first) <= most:
            return points[np.sort(order[first])]
        cell *= max(1.1, 0.95 * np.sqrt(len(first) / most))
