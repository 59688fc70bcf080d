"""Signed distances from points to a cloud, measured to locally fitted planes."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray, Int32Array, IntArray
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.nearby.point_grid import PointGrid
from vomstudio.registration.surface_points import Counterparts

RADIUS = 4.0
"""Radius of the ball of a local plane, in resolutions of the cloud; contains some fifty points."""
_MAX_GAP = 3.0
"""Distance to the nearest point along the surface, in resolutions, from which a position is beyond
the edge: the nearest neighbour of one in 1e12 random points on a plane is this far away."""
_BLOCK_SIZE = 200_000
_MAX_COARSE_POINTS = 20_000
_N_NEIGHBOURS = 10
_MIN_MEAN_NORMAL = 0.05


class OrientedCloud:
    """Cloud with consistent normals, for signed distances.

    Parameters
    ----------
    cloud : PointCloud
    resolution : float
        Resolution of the points, in the unit of the cloud.
    direction : ((m, 3) array, (m, 3) array), optional
        Points and normals of a nearby surface with known sides, for a cloud whose file has no
        normals.
    """

    def __init__(
        self,
        cloud: PointCloud,
        resolution: float,
        direction: tuple[FloatArray, FloatArray] | None = None,
    ) -> None:
        from scipy.spatial import cKDTree

        is_finite = np.isfinite(cloud.points).all(axis=1)
        self._points = np.asarray(cloud.points[is_finite], np.float64)
        self._origin = self._points[0] if len(self._points) else np.zeros(3)
        self.resolution = resolution
        self._tree = cKDTree(
            self._points - self._origin, leafsize=32, compact_nodes=False, balanced_tree=False
        )
        self._radius = RADIUS * resolution
        self._grid = PointGrid(self._points, self._radius)
        self.source = "file"
        if has_point_normals(cloud):
            assert cloud.normals is not None
            self._file_normals: FloatArray | None = np.asarray(cloud.normals[is_finite], np.float64)
            self._oriented_samples = None
        else:
            self._file_normals = None
            self._oriented_samples = self._orient_samples(direction)

    @property
    def mean_normal(self) -> FloatArray:
        """Sum (3,) of the normals of points distributed over the cloud."""
        if self._file_normals is not None:
            return np.asarray(self._file_normals.sum(axis=0), np.float64)
        assert self._oriented_samples is not None
        return np.asarray(self._oriented_samples[1].sum(axis=0), np.float64)

    @property
    def total(self) -> float:
        """Length that the sum of the normals would have if they were parallel."""
        normals = (
            self._file_normals if self._file_normals is not None else self._oriented_samples[1]  # type: ignore[index]
        )
        return float(np.linalg.norm(normals, axis=1).sum())

    def find_counterparts(
        self, positions: FloatArray, progress: Progress | None = None
    ) -> Counterparts:
        """Return the signed distances of positions (n, 3).

        Each step of `progress`, which may raise Cancelled, is one position.
        """
        progress = progress or SilentProgress()
        n = len(positions)
        distance, distance_beyond_edge, normal = (
            np.full(n, np.nan),
            np.zeros(n),
            np.full((n, 3), np.nan),
        )
        for start in range(0, n, _BLOCK_SIZE):
            rows = slice(start, min(start + _BLOCK_SIZE, n))
            distance[rows], distance_beyond_edge[rows], normal[rows] = self._measure_block(
                positions[rows]
            )
            progress.step(rows.stop)
        return Counterparts(distance, distance_beyond_edge, normal)

    def _measure_block(self, positions: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        n = len(positions)
        distance, distance_beyond_edge, normal = (
            np.full(n, np.nan),
            np.zeros(n),
            np.full((n, 3), np.nan),
        )
        rows = np.flatnonzero(np.isfinite(positions).all(axis=1))
        _, nearest_rows = self._tree.query(positions[rows] - self._origin, workers=-1)
        unique_rows, inverse = np.unique(nearest_rows, return_inverse=True)
        planes = self._grid.planes(self._points[unique_rows], self._radius)
        # Fewer than three points, or collinear points, have no plane: use the nearest point.
        has_plane = planes.spread[:, 1] > 1e-9 * planes.spread[:, 2]
        normals = self.orient_normals(self._points[unique_rows], planes.normal, unique_rows)
        normals, has_plane, centre = normals[inverse], has_plane[inverse], planes.mean[inverse]
        offset = positions[rows] - self._points[nearest_rows]
        length = np.linalg.norm(offset, axis=1)
        height = np.einsum("ij,ij->i", offset, normals)
        tangential_distance = np.sqrt(np.maximum(length**2 - height**2, 0.0))
        signed_distances = np.einsum("ij,ij->i", positions[rows] - centre, normals)
        distance[rows] = np.where(has_plane, signed_distances, length)
        distance_beyond_edge[rows] = np.where(
            has_plane & (tangential_distance <= _MAX_GAP * self.resolution),
            0.0,
            tangential_distance,
        )
        normal[rows] = normals
        return distance, distance_beyond_edge, normal

    def orient_normals(
        self, positions: FloatArray, normals: FloatArray, rows: IntArray | None = None
    ) -> FloatArray:
        """Orient normals (k, 3) at positions (k, 3) to the same side as those of the cloud.

        `rows` (k,) are the rows of the positions in the cloud, if they are its points.
        """
        if self._file_normals is not None:
            if rows is None:
                rows = np.asarray(self._tree.query(positions - self._origin, workers=-1)[1])
            reference_normals = self._file_normals[rows]
        else:
            from scipy.spatial import cKDTree

            assert self._oriented_samples is not None
            reference_normals = self._oriented_samples[1][
                cKDTree(self._oriented_samples[0]).query(positions)[1]
            ]
        signs = np.where(np.einsum("ij,ij->i", normals, reference_normals) < 0, -1.0, 1.0)
        return np.asarray(normals * signs[:, None], np.float64)

    # --- sides of a cloud without normals ---------------------------------------------------------
    def _orient_samples(
        self, direction: tuple[FloatArray, FloatArray] | None
    ) -> tuple[FloatArray, FloatArray]:
        """Return some points of the cloud, and their normals, all on the same side."""
        from scipy.spatial import cKDTree

        positions = self._points[:: max(1, len(self._points) // _MAX_COARSE_POINTS)]
        # Use normals at a scale at which neighbours among these few points are similar.
        sparse_spacing = self.resolution * np.sqrt(
            max(len(self._points) / max(len(positions), 1), 1.0)
        )
        radius = max(self._radius, 2.0 * sparse_spacing)
        planes = PointGrid(self._points, radius).planes(positions, radius)
        is_valid = np.isfinite(planes.normal).all(axis=1)
        positions, normals = positions[is_valid], planes.normal[is_valid]
        if not len(positions):
            return self._points[:1], np.array([[0.0, 0.0, 1.0]])
        normals, parts = propagate_orientation(positions, normals)
        neighbours = None
        if direction is not None and len(direction[0]):
            neighbours = direction[1][cKDTree(direction[0]).query(positions)[1]]
        self.source = "up" if neighbours is None else "model"
        for part in np.unique(parts):
            rows = parts == part
            if neighbours is not None:
                side = float(np.einsum("ij,ij->", normals[rows], neighbours[rows]))
            else:
                side = upward_component(normals[rows].sum(axis=0))
            if side < 0:
                normals[rows] *= -1.0
        return positions, normals


def has_point_normals(cloud: PointCloud) -> bool:
    """Return whether every point has a normal; some files contain columns of zeros.

    Parameters
    ----------
    cloud : PointCloud

    Returns
    -------
    bool
    """
    normals = cloud.normals
    return normals is not None and bool((np.abs(normals).max(axis=1, initial=0.0) > 0.5).all())


def upward_component(mean: FloatArray) -> float:
    """Return a number whose sign shows whether a vector points up.

    A nearly horizontal vector is positive if it points east or, failing that, north.

    Parameters
    ----------
    mean : (3,) ndarray

    Returns
    -------
    float
        Positive if the vector points up.
    """
    size = float(np.linalg.norm(mean))
    for axis in (2, 0, 1):
        if abs(mean[axis]) > _MIN_MEAN_NORMAL * size:
            return float(mean[axis])
    return 1.0


def propagate_orientation(
    positions: FloatArray, normals: FloatArray
) -> tuple[FloatArray, Int32Array]:
    """Orient normals consistently by propagation between neighbours.

    The most nearly parallel neighbours are processed first (Hoppe et al. 1992, SIGGRAPH 26, 71).

    Parameters
    ----------
    positions, normals : (k, 3) array

    Returns
    -------
    normals : (k, 3) array
    parts : (k,) array of int
        Index of the connected part of each position.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import (
        breadth_first_order,
        connected_components,
        minimum_spanning_tree,
    )
    from scipy.spatial import cKDTree

    k = len(positions)
    count = min(_N_NEIGHBOURS + 1, k)
    neighbours = np.atleast_2d(cKDTree(positions).query(positions, k=count)[1]).reshape(k, count)
    first_rows, second_rows = np.repeat(np.arange(k), count), neighbours.ravel()
    similarities = np.abs(np.einsum("ij,ij->i", normals[first_rows], normals[second_rows]))
    # An edge with zero weight would be ignored.
    graph = coo_matrix(
        (1.0 + 1e-6 - np.minimum(similarities, 1.0), (first_rows, second_rows)), shape=(k, k)
    ).tocsr()
    tree = minimum_spanning_tree(graph.maximum(graph.T))
    _, parts = connected_components(tree, directed=False)
    oriented_normals = normals.copy()
    for part in np.unique(parts):
        start = int(np.argmax(parts == part))
        order, predecessors = breadth_first_order(tree, start, directed=False)
        for row in order[1:].tolist():
            if oriented_normals[row] @ oriented_normals[predecessors[row]] < 0:
                oriented_normals[row] *= -1.0
    return oriented_normals, np.asarray(parts, np.int32)
