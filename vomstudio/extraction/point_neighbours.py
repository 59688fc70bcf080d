"""Neighbourhoods of individual points of a cloud: neighbours, normals and scatter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array, IntArray
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.extraction.kernels import fit_local_planes
from vomstudio.geometry.kernels.cell_lists import block_planes, cell_moments, nearest_in_block
from vomstudio.geometry.kernels.jit import to_kernel_array
from vomstudio.geometry.nearby.cell_grid import CellGrid, create_cell_grid
from vomstudio.geometry.nearby.point_grid import run_in_blocks

N_NEIGHBOURS = 12
"""Number of neighbours to which a facet can grow from a point."""
NORMAL_POINT_COUNTS = (16, 32, 64, 96)
"""Numbers of points for a normal; more are used if noise makes neighbouring normals differ."""
MAX_ANGLE_SHARE = 0.25
"""Maximum median angle between neighbouring normals, as a fraction of the threshold angle."""
MIN_CELL_CLOUD_POINTS = 50_000
"""Minimum size of a cloud that is first analysed on cells."""
_N_SAMPLE_POINTS = 4_000
_POINTS_PER_BLOCK = 20_000
# Minimum variation of points whose noise exceeds their spacing, and quantile at which it is tested.
# The variation is about 0 for a plane, 0.1 at an edge of 90 degrees, and above this value for the
# largest neighbourhoods if the noise is 1.7 spacings.
_MIN_NOISY_VARIATION, _QUIET_QUANTILE = 0.11, 0.2
# Maximum median variation of the vertices of a mesh; noise of one side length has twice this value.
_MAX_FLAT_VARIATION = 0.08
# Minimum variation and number of scattered points, and points per cell. A hundred points that fill
# a block exceed this variation in 98 of 100 cases; points of a plane among as many scattered points
# almost never do.
_MIN_SCATTERED_VARIATION, _MIN_BLOCK_POINTS, _POINTS_PER_CELL = 0.22, 60, 4.0


@dataclass(frozen=True, eq=False)
class PointNeighbourhoods:
    """Neighbourhoods of k points.

    Parameters
    ----------
    neighbours : (k, m) int32 array
        Nearest points of each point.
    farthest_distances : (k,) array
        Distance from each point to the farthest of these neighbours.
    normals : (k, 3) array
    variation : (k,) array
    point_counts : (k,) int array
        Number of points used for the normal and the variation.
    """

    neighbours: Int32Array
    farthest_distances: FloatArray
    normals: FloatArray
    variation: FloatArray
    point_counts: IntArray


def is_noise_dominated(positions: FloatArray) -> bool:
    """Return whether the noise of points exceeds their spacing.

    In this case, even the largest neighbourhoods fill a volume rather than a surface. If some part
    of the cloud is not noisy, all points can be analysed individually. The result is False for a
    small cloud.

    Parameters
    ----------
    positions : (n, 3) ndarray

    Returns
    -------
    bool
    """
    max_count = NORMAL_POINT_COUNTS[-1]
    if len(positions) < 4 * max_count:
        return False
    sample = np.arange(0, len(positions), max(1, len(positions) // _N_SAMPLE_POINTS))
    neighbours = np.ascontiguousarray(
        _build_tree(positions).query(positions[sample], k=max_count)[1], np.int32
    )
    # The smallest neighbourhoods are tested as well: two close sheets may have little noise.
    return all(
        float(np.quantile(np.nan_to_num(variation), _QUIET_QUANTILE)) > _MIN_NOISY_VARIATION
        for _, variation in (
            _fit_planes(positions, sample, np.ascontiguousarray(neighbours[:, :count]))
            for count in (NORMAL_POINT_COUNTS[0], max_count)
        )
    )


def find_scattered_points(positions: FloatArray) -> tuple[BoolArray, float]:
    """Find points that scatter in all directions and therefore do not define a plane.

    Parameters
    ----------
    positions : (n, 3) ndarray

    Returns
    -------
    is_scattered : (n,) ndarray of bool
    area : float
        Area represented by each of these points.
    """
    low = positions.min(axis=0)
    grid = create_cell_grid(positions - low, _POINTS_PER_CELL)
    starts, neighbours = grid.neighbouring_cells()
    m = len(grid.keys)
    means, covariances = np.empty((m, 3)), np.empty((m, 6))
    cell_moments(grid.places, grid.starts, means, covariances)
    count, normals, eigenvalues = np.empty(m, np.int64), np.empty((m, 3)), np.empty((m, 3))
    block_planes(
        0, m, grid.starts, means, covariances, starts, neighbours, count, normals, eigenvalues
    )
    is_filled = (count >= _MIN_BLOCK_POINTS) & (
        eigenvalues[:, 0] > _MIN_SCATTERED_VARIATION * eigenvalues.sum(axis=1)
    )
    area = grid.cell_size**2 / _POINTS_PER_CELL ** (2.0 / 3.0)
    return np.repeat(is_filled, np.diff(grid.starts))[grid.inverse_rows], area


def estimate_normals(
    positions: FloatArray, angle_deg: float, progress: Progress
) -> FloatArray | None:
    """Estimate the normals of points from their nearest neighbours.

    All points use the same number of neighbours: the smallest of `NORMAL_POINT_COUNTS` at which the
    normals of adjacent points agree within `MAX_ANGLE_SHARE` of `angle_deg`, or else the largest.

    Parameters
    ----------
    positions : (n, 3) ndarray
    angle_deg : float
        Threshold angle between the normals of neighbours, degrees.
    progress : Progress

    Returns
    -------
    (n, 3) ndarray or None
        Unit normals; None if the neighbourhoods are not flat.
    """
    tree = _build_tree(positions)
    neighbour_count = _required_neighbour_count(tree, positions, angle_deg, 0.5)
    normals, variation = np.empty((len(positions), 3)), np.empty(len(positions))

    def process_block(block: slice) -> None:
        rows = np.arange(block.start, block.stop)
        neighbours = np.ascontiguousarray(
            tree.query(positions[rows], k=neighbour_count)[1], np.int32
        )
        normals[block], variation[block] = _fit_planes(positions, rows, neighbours)

    run_in_blocks(process_block, len(positions), progress, _POINTS_PER_BLOCK)
    return normals if float(np.nanmedian(variation)) < _MAX_FLAT_VARIATION else None


def find_neighbourhoods(
    grid: CellGrid,
    rows: IntArray,
    is_sparse: BoolArray | None,
    known_count: int | None,
    angle_deg: float,
    progress: Progress,
) -> tuple[int, PointNeighbourhoods]:
    """Find the neighbourhoods of selected points.

    Parameters
    ----------
    grid : CellGrid
    rows : (k,) int array
        Rows of the points.
    is_sparse : (cells,) bool array or None
        Cells in sparse surroundings, for which the smallest number of neighbours is sufficient
        because noise of the same width is smaller relative to the spacing. None if the cloud
        was not analysed on cells.
    known_count : int or None
        Number of neighbours, if already known.
    angle_deg : float
        Threshold angle between the normals of neighbours, degrees.
    progress : Progress

    Returns
    -------
    required_count : int
        Number of points used for a normal.
    surroundings : PointNeighbourhoods
    """
    progress.stage(tr("Finding neighbours"), None)
    positions = grid.places
    tree = (
        None
        if known_count and is_sparse is not None and len(positions) >= MIN_CELL_CLOUD_POINTS
        else _build_tree(positions)
    )
    # Points within planes have little noise.
    share = 1.0 - 0.5 * len(positions) / len(rows) if 2 * len(rows) > len(positions) else 0.0
    known_count = known_count if len(rows) else NORMAL_POINT_COUNTS[0]
    required_count = (
        min(known_count, len(positions))
        if known_count
        else _required_neighbour_count(tree, positions, angle_deg, share)
    )
    k, neighbour_count = len(rows), min(N_NEIGHBOURS, len(positions) - 1)
    surroundings = PointNeighbourhoods(
        np.empty((k, neighbour_count), np.int32),
        np.empty(k),
        np.empty((k, 3)),
        np.empty(k),
        np.full(k, required_count),
    )
    progress.stage(tr("Computing normals"), k)
    if is_sparse is None or len(positions) < MIN_CELL_CLOUD_POINTS:
        _search_tree(tree, positions, None, rows, np.arange(k), surroundings, progress)
        return required_count, surroundings
    cells = grid.find_cells(rows)
    is_in_sparse_cell = is_sparse[cells]
    surroundings.point_counts[is_in_sparse_cell] = min(NORMAL_POINT_COUNTS[0], required_count)
    is_open = np.ones(k, np.bool_)
    _search_cells(
        grid, rows, cells, np.flatnonzero(~is_in_sparse_cell), surroundings, is_open, progress
    )
    open_indices = np.flatnonzero(is_open)
    if not len(open_indices):
        return required_count, surroundings
    subset = None
    if tree is None:
        subset = _select_neighbourhoods(
            grid, is_sparse, np.unique(cells[is_open & ~is_in_sparse_cell])
        )
        subset = None if len(subset) < 2 * NORMAL_POINT_COUNTS[-1] else subset
        tree = _build_tree(
            positions if subset is None else to_kernel_array(positions[subset], np.float64)
        )
    for group in (
        open_indices[~is_in_sparse_cell[open_indices]],
        open_indices[is_in_sparse_cell[open_indices]],
    ):
        _search_tree(tree, positions, subset, rows, group, surroundings, progress)
    return required_count, surroundings


def _select_neighbourhoods(grid: CellGrid, is_sparse: BoolArray, cells: IntArray) -> IntArray:
    """Select the points needed to find neighbourhoods in given cells and in sparse cells.

    These are all points in sparse cells, in `cells` and in the neighbours of `cells`, and one
    point of each other cell.
    """
    starts, neighbours = grid.neighbouring_cells()
    is_used = is_sparse.copy()
    is_used[cells] = True
    is_selected = np.zeros(len(is_used), np.bool_)
    is_selected[cells] = True
    is_used[neighbours[np.repeat(is_selected, np.diff(starts))]] = True
    is_kept = np.repeat(is_used, np.diff(grid.starts))
    is_kept[grid.starts[:-1]] = True
    return np.flatnonzero(is_kept)


def _search_cells(
    grid: CellGrid,
    rows: IntArray,
    cells: IntArray,
    selected_indices: IntArray,
    surroundings: PointNeighbourhoods,
    is_open: BoolArray,
    progress: Progress,
) -> None:
    """Find the neighbourhoods of selected points within their own and the adjacent cells.

    `is_open` is set to False for each point for which these cells are sufficient.
    """
    if not len(selected_indices):
        return
    starts, neighbouring_cells = grid.neighbouring_cells()
    point_counts, neighbour_count = (
        int(surroundings.point_counts[selected_indices[0]]),
        surroundings.neighbours.shape[1],
    )

    def process_block(block: slice) -> None:
        position = selected_indices[block]
        neighbours = np.empty((len(position), point_counts), np.int32)
        squared_distances, is_known = (
            np.empty((len(position), point_counts)),
            np.empty(len(position), np.bool_),
        )
        centres = to_kernel_array(rows[position], np.int64)
        nearest_in_block(
            grid.places,
            grid.starts,
            starts,
            neighbouring_cells,
            grid.keys,
            grid.row,
            grid.layer,
            grid.cell_size,
            centres,
            to_kernel_array(cells[position], np.int64),
            neighbours,
            squared_distances,
            is_known,
        )
        position, neighbours = position[is_known], neighbours[is_known]
        surroundings.normals[position], surroundings.variation[position] = _fit_planes(
            grid.places, rows[position], neighbours
        )
        surroundings.neighbours[position], surroundings.farthest_distances[position] = (
            neighbours[:, 1 : neighbour_count + 1],
            np.sqrt(squared_distances[is_known, neighbour_count]),
        )
        is_open[position] = False

    run_in_blocks(process_block, len(selected_indices), progress, _POINTS_PER_BLOCK)


def _search_tree(
    tree: Any,
    positions: FloatArray,
    subset: IntArray | None,
    rows: IntArray,
    selected_indices: IntArray,
    surroundings: PointNeighbourhoods,
    progress: Progress,
) -> None:
    """Find the neighbourhoods of selected points with a search tree of all or some points."""
    if not len(selected_indices):
        return
    point_counts, neighbour_count = (
        int(surroundings.point_counts[selected_indices[0]]),
        surroundings.neighbours.shape[1],
    )

    def process_block(block: slice) -> None:
        position = selected_indices[block]
        distance, neighbours = tree.query(positions[rows[position]], k=point_counts)
        neighbours = np.ascontiguousarray(
            neighbours if subset is None else subset[neighbours], np.int32
        )
        surroundings.normals[position], surroundings.variation[position] = _fit_planes(
            positions, rows[position], neighbours
        )
        surroundings.neighbours[position], surroundings.farthest_distances[position] = (
            neighbours[:, 1 : neighbour_count + 1],
            distance[:, neighbour_count],
        )

    run_in_blocks(process_block, len(selected_indices), progress, _POINTS_PER_BLOCK)


def _build_tree(positions: FloatArray) -> Any:
    from scipy.spatial import cKDTree

    return cKDTree(positions, leafsize=16, compact_nodes=False, balanced_tree=False)


def _fit_planes(
    positions: FloatArray, rows: IntArray, neighbours: Int32Array
) -> tuple[FloatArray, FloatArray]:
    """Return the normals and variations of planes through the neighbours (k, m) of rows (k,)."""
    results = np.empty((len(rows), 3)), np.empty(len(rows))
    fit_local_planes(positions, to_kernel_array(positions[rows], np.float64), neighbours, *results)
    return results


def _required_neighbour_count(
    tree: Any, positions: FloatArray, angle_deg: float, share: float
) -> int:
    """Return the number of neighbours at which adjacent normals agree.

    The number is determined from a sample. `share` is the fraction of the points whose normals
    must agree.
    """
    n = len(positions)
    sample = np.arange(0, n, max(1, n // _N_SAMPLE_POINTS))
    used_count = min(NORMAL_POINT_COUNTS[0], n)
    for count in NORMAL_POINT_COUNTS:
        used_count = min(count, n)
        _, rows = tree.query(positions[sample], k=used_count)
        # Compare with the plane around the fourth neighbour.
        neighbours = rows[:, min(4, used_count - 1)]
        _, second_rows = tree.query(positions[neighbours], k=used_count)
        normals = [
            _fit_planes(positions, position, np.ascontiguousarray(nearest_rows, np.int32))[0]
            for position, nearest_rows in ((sample, rows), (neighbours, second_rows))
        ]
        cosine = np.abs((normals[0] * normals[1]).sum(axis=1))
        cosine = cosine[np.isfinite(cosine)]
        if not len(cosine):
            break
        if (
            np.degrees(np.arccos(min(float(np.quantile(cosine, 1.0 - share)), 1.0)))
            <= MAX_ANGLE_SHARE * angle_deg
        ):
            break
        if used_count == n:
            break
    return used_count
