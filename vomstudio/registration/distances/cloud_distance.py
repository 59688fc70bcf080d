"""Signed distances from points to a cloud: to the planes that are fitted to it locally."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray, Int32Array, IntArray
from vomstudio.core.progress import Progress, Silent
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.nearby.point_grid import PointGrid
from vomstudio.registration.surface_points import Opposite

RADIUS = 4.0
"""Of the ball whose points make a local plane, in resolutions of the cloud: some fifty points, a
surface's own bends as far as it shows them."""
_GAP = 3.0
"""A place this many resolutions from the nearest point, along the surface, is beyond its edge: of
points at random on a plane one in 1e12 has its nearest neighbour so far away."""
_BLOCK = 200_000
_COARSE = 20_000
_NEIGHBOURS = 10
_OF_ONE_SIDE = 0.05


class CloudSides:
    """A cloud, ready to be asked on which side of it places lie, and how far.

    resolution : of its points, in its own unit
    toward : (m, 3) places and (m, 3) normals of a surface with sides that lies near, for a cloud
        whose file tells none
    """

    def __init__(
        self,
        cloud: PointCloud,
        resolution: float,
        toward: tuple[FloatArray, FloatArray] | None = None,
    ) -> None:
        from scipy.spatial import cKDTree

        sound = np.isfinite(cloud.points).all(axis=1)
        self._points = np.asarray(cloud.points[sound], np.float64)
        self._origin = self._points[0] if len(self._points) else np.zeros(3)
        self.resolution = resolution
        self._tree = cKDTree(
            self._points - self._origin, leafsize=32, compact_nodes=False, balanced_tree=False
        )
        self._radius = RADIUS * resolution
        self._grid = PointGrid(self._points, self._radius)
        self.told_by = "file"
        if has_sides(cloud):
            assert cloud.normals is not None
            self._own: FloatArray | None = np.asarray(cloud.normals[sound], np.float64)
            self._sides = None
        else:
            self._own = None
            self._sides = self._find_sides(toward)

    @property
    def mean_normal(self) -> FloatArray:
        """(3,) sum of the normals of points spread over it."""
        if self._own is not None:
            return np.asarray(self._own.sum(axis=0), np.float64)
        assert self._sides is not None
        return np.asarray(self._sides[1].sum(axis=0), np.float64)

    @property
    def total(self) -> float:
        """As long as that sum would be if all lay alike."""
        normals = self._own if self._own is not None else self._sides[1]  # type: ignore[index]
        return float(np.linalg.norm(normals, axis=1).sum())

    def opposite(self, places: FloatArray, progress: Progress | None = None) -> Opposite:
        """What of the cloud lies opposite the places (n, 3). Raises Cancelled through `progress`,
        whose steps are places."""
        progress = progress or Silent()
        n = len(places)
        distance, beside, normal = np.full(n, np.nan), np.zeros(n), np.full((n, 3), np.nan)
        for start in range(0, n, _BLOCK):
            rows = slice(start, min(start + _BLOCK, n))
            distance[rows], beside[rows], normal[rows] = self._block(places[rows])
            progress.step(rows.stop)
        return Opposite(distance, beside, normal)

    def _block(self, places: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        n = len(places)
        distance, beside, normal = np.full(n, np.nan), np.zeros(n), np.full((n, 3), np.nan)
        rows = np.flatnonzero(np.isfinite(places).all(axis=1))
        _, nearest = self._tree.query(places[rows] - self._origin, workers=-1)
        which, again = np.unique(nearest, return_inverse=True)
        planes = self._grid.planes(self._points[which], self._radius)
        # Fewer than three points, or points on a line, have no plane: the nearest point counts.
        flat = planes.spread[:, 1] > 1e-9 * planes.spread[:, 2]
        ways = self.turned(self._points[which], planes.normal, which)
        ways, flat, middle = ways[again], flat[again], planes.mean[again]
        off = places[rows] - self._points[nearest]
        straight = np.linalg.norm(off, axis=1)
        along = np.einsum("ij,ij->i", off, ways)
        aside = np.sqrt(np.maximum(straight**2 - along**2, 0.0))
        signed = np.einsum("ij,ij->i", places[rows] - middle, ways)
        distance[rows] = np.where(flat, signed, straight)
        beside[rows] = np.where(flat & (aside <= _GAP * self.resolution), 0.0, aside)
        normal[rows] = ways
        return distance, beside, normal

    def turned(
        self, places: FloatArray, normals: FloatArray, rows: IntArray | None = None
    ) -> FloatArray:
        """(k, 3) normals at places turned to the cloud's side. rows : of its points, where the
        places are these"""
        if self._own is not None:
            if rows is None:
                rows = np.asarray(self._tree.query(places - self._origin, workers=-1)[1])
            sides = self._own[rows]
        else:
            from scipy.spatial import cKDTree

            assert self._sides is not None
            sides = self._sides[1][cKDTree(self._sides[0]).query(places)[1]]
        signs = np.where(np.einsum("ij,ij->i", normals, sides) < 0, -1.0, 1.0)
        return np.asarray(normals * signs[:, None], np.float64)

    # --- sides of a cloud without normals ---------------------------------------------------------
    def _find_sides(
        self, toward: tuple[FloatArray, FloatArray] | None
    ) -> tuple[FloatArray, FloatArray]:
        """Some places of the cloud, and normals that are all on one side."""
        from scipy.spatial import cKDTree

        places = self._points[:: max(1, len(self._points) // _COARSE)]
        # Normals of a scale at which neighbours of these few places are like each other.
        sparse = self.resolution * np.sqrt(max(len(self._points) / max(len(places), 1), 1.0))
        radius = max(self._radius, 2.0 * sparse)
        planes = PointGrid(self._points, radius).planes(places, radius)
        sound = np.isfinite(planes.normal).all(axis=1)
        places, normals = places[sound], planes.normal[sound]
        if not len(places):
            return self._points[:1], np.array([[0.0, 0.0, 1.0]])
        normals, parts = spread_side(places, normals)
        near = None
        if toward is not None and len(toward[0]):
            near = toward[1][cKDTree(toward[0]).query(places)[1]]
        self.told_by = "up" if near is None else "model"
        for part in np.unique(parts):
            rows = parts == part
            if near is not None:
                side = float(np.einsum("ij,ij->", normals[rows], near[rows]))
            else:
                side = upper_side(normals[rows].sum(axis=0))
            if side < 0:
                normals[rows] *= -1.0
        return places, normals


def has_sides(cloud: PointCloud) -> bool:
    """Whether each point has a normal; some files have columns of zeros."""
    normals = cloud.normals
    return normals is not None and bool((np.abs(normals).max(axis=1, initial=0.0) > 0.5).all())


def upper_side(mean: FloatArray) -> float:
    """Positive of a vector that points up; of one nearly level that points east, or north."""
    size = float(np.linalg.norm(mean))
    for axis in (2, 0, 1):
        if abs(mean[axis]) > _OF_ONE_SIDE * size:
            return float(mean[axis])
    return 1.0


def spread_side(places: FloatArray, normals: FloatArray) -> tuple[FloatArray, Int32Array]:
    """(k, 3) normals of k places on a surface turned to one side, which spreads from neighbour to
    neighbour, most alike first (Hoppe et al. 1992, SIGGRAPH 26, 71); and (k,) which of them hang
    together."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import (
        breadth_first_order,
        connected_components,
        minimum_spanning_tree,
    )
    from scipy.spatial import cKDTree

    k = len(places)
    count = min(_NEIGHBOURS + 1, k)
    near = np.atleast_2d(cKDTree(places).query(places, k=count)[1]).reshape(k, count)
    first, second = np.repeat(np.arange(k), count), near.ravel()
    alike = np.abs(np.einsum("ij,ij->i", normals[first], normals[second]))
    # An edge of length zero would be none.
    graph = coo_matrix((1.0 + 1e-6 - np.minimum(alike, 1.0), (first, second)), shape=(k, k)).tocsr()
    tree = minimum_spanning_tree(graph.maximum(graph.T))
    _, parts = connected_components(tree, directed=False)
    turned = normals.copy()
    for part in np.unique(parts):
        start = int(np.argmax(parts == part))
        order, before = breadth_first_order(tree, start, directed=False)
        for row in order[1:].tolist():
            if turned[row] @ turned[before[row]] < 0:
                turned[row] *= -1.0
    return turned, np.asarray(parts, np.int32)
