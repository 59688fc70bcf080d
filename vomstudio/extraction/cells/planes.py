"""Planes of a dense cloud, found on cells of sixteen or more points each.

Within a rock face, neighbouring points lie in the same plane, so they can be analysed together.
Edges, small pieces and rough ground, which cells cannot resolve, are analysed point by point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.progress import Progress
from vomstudio.extraction.cells.kernels import assign_points, copy_to_points, describe_cells
from vomstudio.extraction.elements import (
    MIN_POINTS_AROUND,
    CellPlanes,
    Elements,
    approximate_median,
)
from vomstudio.extraction.growing import element_tolerances, facet_limits, facet_planes, grow_facets
from vomstudio.extraction.point_neighbours import is_noise_dominated
from vomstudio.geometry.kernels.cell_lists import block_planes, cell_moments
from vomstudio.geometry.kernels.jit import to_kernel_array
from vomstudio.geometry.nearby.cell_grid import CellGrid, create_cell_grid
from vomstudio.geometry.nearby.point_grid import run_in_blocks

_POINTS_PER_CELL = 16.0
_CELL_GROWTH = 2.5
# Not from a paper: maximum typical variation, above which larger cells are used, and maximum
# variation of a single cell; an edge of 60 degrees reaches this value.
_MAX_TYPICAL_VARIATION, _MAX_CELL_VARIATION = 0.02, 0.06
# At this variation, one standard deviation of the scatter is a tenth of the cell size.
_MAX_THIN_VARIATION = 0.007
_MIN_CELLS = 40
_MIN_POINTS_PER_CELL = 6
# The same if the noise exceeds the spacing: a face has fewer cells, with a few hundred points each.
# The scatter about a surface does not increase with the cell size, but that of separate pieces
# does.
_POINTS_PER_NOISY_CELL, _NOISY_CELL_GROWTH = 100.0, 1.5
_MAX_NOISY_TYPICAL_VARIATION, _MAX_NOISY_CELL_VARIATION = 0.035, 0.07
_MIN_NOISY_CELLS = 9
_MAX_NOISE_GROWTH = 1.5
_CELLS_PER_SAMPLE_RUN, _N_SAMPLE_RUNS, _SAMPLE_MARGIN_FACTOR = 64, 100, 1.25
_CELLS_PER_BLOCK = 10_000


def find_cell_planes(
    local_points: FloatArray,
    angle_deg: float,
    max_distance: float | None,
    min_points: int,
    min_area: float,
    progress: Progress,
    is_noisy: bool = False,
) -> tuple[CellGrid, CellPlanes]:
    """Find planes on cells and transfer them to the points.

    Parameters
    ----------
    local_points : (n, 3) array
        Points relative to an origin at or below their minimum.
    angle_deg : float
        Maximum angle between the normal of a cell and the plane of its facet, degrees.
    max_distance : float or None
        Maximum distance from a plane, m.
    min_points, min_area
        Minimum number of points and minimum area (m²) of a facet; smaller planes are left to the
        analysis of individual points.
    progress : Progress
    is_noisy : bool
        Whether the noise is known to exceed the spacing, so that only wide neighbourhoods are used.
        If False, this is detected on the cells.

    Returns
    -------
    CellGrid, CellPlanes

    Raises
    ------
    Cancelled
        Through `progress`.
    """
    search = (
        None
        if is_noisy
        else _find_flat_cells(
            local_points, _POINTS_PER_CELL, _CELL_GROWTH, _MAX_TYPICAL_VARIATION, progress
        )
    )
    min_cells, max_variation, width = _MIN_CELLS, _MAX_CELL_VARIATION, 0.0
    if search is None or (
        search.typical_variation > _MAX_TYPICAL_VARIATION and is_noise_dominated(search.grid.places)
    ):
        search = _find_flat_cells(
            local_points,
            _POINTS_PER_NOISY_CELL,
            _NOISY_CELL_GROWTH,
            _MAX_NOISY_TYPICAL_VARIATION,
            progress,
        )
        min_cells, max_variation = _MIN_NOISY_CELLS, _MAX_NOISY_CELL_VARIATION
        width = search.width if search.typical_variation <= _MAX_NOISY_TYPICAL_VARIATION else np.inf
    grid, cells = search.grid, search.cells
    # If the cells of a cloud have no normals, every point is analysed individually.
    if width > search.width or (not width and search.typical_variation > _MAX_TYPICAL_VARIATION):
        max_variation = -1.0
    cells.normals[(search.count < MIN_POINTS_AROUND) | (cells.variation > max_variation)] = np.nan
    extent_radius = element_tolerances(cells, max_distance)
    typical_reach = approximate_median(extent_radius)
    labels = grow_facets(
        cells,
        angle_deg=angle_deg,
        max_distances=extent_radius,
        min_count=min_cells,
        min_area=np.inf,
        typical_tolerance=typical_reach,
        progress=progress,
    )
    planes = facet_planes(cells, labels)
    is_inside = labels >= 0
    points = np.bincount(labels[is_inside], np.diff(grid.starts)[is_inside], len(planes.area))
    is_small = np.append((points < min_points) | (planes.area < min_area), False)
    labels[is_small[labels]] = -1
    n = len(grid.places)
    point_labels, is_open = np.empty(n, np.int32), np.empty(n, np.bool_)
    assign_points(
        grid.places,
        grid.starts,
        cells.starts,
        cells.neighbours,
        labels,
        to_kernel_array(cells.normals, np.float64),
        extent_radius,
        float(np.cos(np.radians(angle_deg))),
        to_kernel_array(planes.centre, np.float64),
        to_kernel_array(planes.normal, np.float64),
        facet_limits(planes, typical_reach),
        point_labels,
        is_open,
    )
    point_values = np.empty((n, 3)), np.empty(n), np.empty(n), np.empty(n)
    copy_to_points(
        grid.starts,
        to_kernel_array(cells.normals, np.float64),
        cells.variation,
        cells.areas,
        cells.noise,
        *point_values,
    )
    return grid, CellPlanes(point_labels, is_open, *point_values, width)


@dataclass(frozen=True, eq=False)
class _CellSearch:
    """Cells with the number of points in and around each of them.

    `typical_variation` is a median; `width` is the typical width of a cell including its
    neighbours, m.
    """

    grid: CellGrid
    cells: Elements
    count: IntArray
    typical_variation: float
    width: float


def _find_flat_cells(
    local_points: FloatArray,
    points_per_cell: float,
    growth_factor: float,
    max_variation: float,
    progress: Progress,
) -> _CellSearch:
    """Enlarge cells until their neighbourhoods are flat, up to ten times `points_per_cell`."""
    max_points_per_cell, min_noise = 10.0 * points_per_cell, np.inf
    while True:
        grid = create_cell_grid(local_points, points_per_cell)
        points_per_cell *= growth_factor
        cell_elements = _cell_elements(
            grid,
            max_variation
            if max_variation <= _MAX_TYPICAL_VARIATION and points_per_cell <= max_points_per_cell
            else np.inf,
            progress,
        )
        if cell_elements is None:
            continue
        cells, count = cell_elements
        points = np.diff(grid.starts)
        typical_variation = approximate_median(np.repeat(cells.variation, points))
        noise = approximate_median(np.repeat(cells.noise, points))
        min_noise = min(min_noise, noise)
        if max_variation > _MAX_TYPICAL_VARIATION and noise > _MAX_NOISE_GROWTH * min_noise:
            typical_variation = np.inf
        if typical_variation <= max_variation or points_per_cell > max_points_per_cell:
            width = approximate_median(np.repeat(np.sqrt(cells.areas / points * count), points))
            return _CellSearch(grid, cells, count, typical_variation, width)


def _cell_elements(
    grid: CellGrid, max_variation: float, progress: Progress
) -> tuple[Elements, IntArray] | None:
    """Build elements from cells, with the number of points in and around each cell.

    Return None if a sample shows that the cells are far from flat.
    """
    m = len(grid.keys)
    starts, neighbours = grid.neighbouring_cells()
    means, inner_moments = np.empty((m, 3)), np.empty((m, 6))
    cell_moments(grid.places, grid.starts, means, inner_moments)
    count, normals, eigenvalues = np.empty(m, np.int64), np.empty((m, 3)), np.empty((m, 3))

    def fit_block(block: slice) -> None:
        block_planes(
            block.start,
            block.stop,
            grid.starts,
            means,
            inner_moments,
            starts,
            neighbours,
            count,
            normals,
            eigenvalues,
        )

    points = np.diff(grid.starts)
    if np.isfinite(max_variation) and m > 2 * _CELLS_PER_SAMPLE_RUN * _N_SAMPLE_RUNS:
        run_starts = np.linspace(0, m - _CELLS_PER_SAMPLE_RUN, _N_SAMPLE_RUNS).astype(np.int64)
        for first in run_starts.tolist():
            fit_block(slice(first, first + _CELLS_PER_SAMPLE_RUN))
        sampled_cells = (run_starts[:, None] + np.arange(_CELLS_PER_SAMPLE_RUN)).ravel()
        sample_variation = eigenvalues[sampled_cells, 0] / np.maximum(
            eigenvalues[sampled_cells].sum(axis=1), 1e-300
        )
        if (
            float(np.median(np.repeat(sample_variation, points[sampled_cells])))
            > _SAMPLE_MARGIN_FACTOR * max_variation
        ):
            return None
    run_in_blocks(fit_block, m, progress, _CELLS_PER_BLOCK)
    area, variation, noise = np.empty(m), np.empty(m), np.empty(m)
    describe_cells(
        grid.starts,
        count,
        inner_moments,
        eigenvalues,
        _MIN_POINTS_PER_CELL,
        _MAX_THIN_VARIATION,
        normals,
        area,
        variation,
        noise,
    )
    return Elements(
        "cell",
        np.zeros(3),
        means,
        normals,
        area * points,
        inner_moments,
        variation,
        np.sqrt(area),
        noise,
        starts,
        neighbours,
        np.arange(m),
        np.arange(m),
    ), count
