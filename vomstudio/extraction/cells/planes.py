"""Planes of a dense cloud, found on cells of some ten points each, and handed down to the points.

Within a face of the rock neighbouring points tell the same, so that it is enough to look at them
together. What cells cannot tell, edges, small pieces and rough ground, is left to single points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.progress import Progress
from vomstudio.extraction.cells.kernels import cell_figures, hand_down, to_points
from vomstudio.extraction.elements import FEWEST_AROUND, Begun, Elements, middle_of
from vomstudio.extraction.growing import grown, limits_of, planes_of, reach_of
from vomstudio.extraction.point_neighbours import drowned
from vomstudio.geometry.kernels.cell_lists import block_planes, cell_moments
from vomstudio.geometry.kernels.jit import for_kernels
from vomstudio.geometry.nearby.cell_grid import CellGrid, create_cell_grid
from vomstudio.geometry.nearby.point_grid import run_in_blocks

_PER_CELL = 16.0
_WIDER = 2.5
# Ours. With more scatter beside their width cells have no normals, and larger ones are taken; none
# is used whose surroundings scatter as much as an edge of 60 degrees does.
_QUIET, _SHARP = 0.02, 0.06
# Below it a tenth of the cell's side is more than one standard deviation of the scatter.
_THIN = 0.007
_LEAST_CELLS = 40
_FEWEST_WITHIN = 6
# The same where noise is larger than the spacing: of cells of a few hundred points a face has
# fewer. The scatter about a surface does not grow with them, that of pieces far apart does.
_NOISY_PER_CELL, _NOISY_WIDER = 100.0, 1.5
_NOISY_QUIET, _NOISY_SHARP = 0.035, 0.07
_NOISY_LEAST_CELLS = 9
_STEADY = 1.5
_RUN, _RUNS, _BY_FAR = 64, 100, 1.25
_BLOCK = 10_000


def begun_on_cells(
    local: FloatArray,
    angle_deg: float,
    max_distance: float | None,
    least_points: int,
    least_area: float,
    progress: Progress,
    noisy: bool = False,
) -> tuple[CellGrid, Begun]:
    """Of points (n, 3) from 0 on. least_points, least_area : that a facet must have, both; smaller
    planes are left to single points; noisy : only surroundings wider than those of single points
    tell normals, which is found out of many points. Raises Cancelled through `progress`."""
    found = None if noisy else _quiet_cells(local, _PER_CELL, _WIDER, _QUIET, progress)
    least_cells, sharp, wide = _LEAST_CELLS, _SHARP, 0.0
    if found is None or (found.usual > _QUIET and drowned(found.grid.places)):
        found = _quiet_cells(local, _NOISY_PER_CELL, _NOISY_WIDER, _NOISY_QUIET, progress)
        least_cells, sharp = _NOISY_LEAST_CELLS, _NOISY_SHARP
        wide = found.width if found.usual <= _NOISY_QUIET else np.inf
    grid, cells = found.grid, found.cells
    # In a cloud whose cells have no normals every point is looked at.
    if wide > found.width or (not wide and found.usual > _QUIET):
        sharp = -1.0
    cells.normals[(found.count < FEWEST_AROUND) | (cells.variation > sharp)] = np.nan
    reach = reach_of(cells, max_distance)
    usual = middle_of(reach)
    labels = grown(
        cells,
        angle_deg=angle_deg,
        reach=reach,
        least_count=least_cells,
        least_area=np.inf,
        usual=usual,
        progress=progress,
    )
    planes = planes_of(cells, labels)
    inside = labels >= 0
    points = np.bincount(labels[inside], np.diff(grid.begins)[inside], len(planes.area))
    small = np.append((points < least_points) | (planes.area < least_area), False)
    labels[small[labels]] = -1
    n = len(grid.places)
    own, open_ = np.empty(n, np.int32), np.empty(n, np.bool_)
    hand_down(
        grid.places,
        grid.begins,
        cells.starts,
        cells.near,
        labels,
        for_kernels(cells.normals, np.float64),
        reach,
        float(np.cos(np.radians(angle_deg))),
        for_kernels(planes.centre, np.float64),
        for_kernels(planes.normal, np.float64),
        limits_of(planes, usual),
        own,
        open_,
    )
    given = np.empty((n, 3)), np.empty(n), np.empty(n), np.empty(n)
    to_points(
        grid.begins,
        for_kernels(cells.normals, np.float64),
        cells.variation,
        cells.areas,
        cells.noise,
        *given,
    )
    return grid, Begun(own, open_, *given, wide)


@dataclass(frozen=True, eq=False)
class _Found:
    """Cells, with how many points are in each and around it; usual : variation; width : m, of a
    cell and those around it, where there are most points"""

    grid: CellGrid
    cells: Elements
    count: IntArray
    usual: float
    width: float


def _quiet_cells(
    local: FloatArray, per_cell: float, wider: float, quiet: float, progress: Progress
) -> _Found:
    """The smallest cells of ten times as many points at most whose surroundings are flat."""
    most, least = 10.0 * per_cell, np.inf
    while True:
        grid = create_cell_grid(local, per_cell)
        per_cell *= wider
        found = _cells(grid, quiet if quiet <= _QUIET and per_cell <= most else np.inf, progress)
        if found is None:
            continue
        cells, count = found
        of = np.diff(grid.begins)
        usual = middle_of(np.repeat(cells.variation, of))
        noise = middle_of(np.repeat(cells.noise, of))
        least = min(least, noise)
        if quiet > _QUIET and noise > _STEADY * least:
            usual = np.inf
        if usual <= quiet or per_cell > most:
            width = middle_of(np.repeat(np.sqrt(cells.areas / of * count), of))
            return _Found(grid, cells, count, usual, width)


def _cells(grid: CellGrid, quiet: float, progress: Progress) -> tuple[Elements, IntArray] | None:
    """The cells as elements, and how many points are in each and around it; None where some of them
    tell that they are by far not quiet."""
    m = len(grid.keys)
    starts, near = grid.around()
    means, inner = np.empty((m, 3)), np.empty((m, 6))
    cell_moments(grid.places, grid.begins, means, inner)
    count, normals, spreads = np.empty(m, np.int64), np.empty((m, 3)), np.empty((m, 3))

    def work(block: slice) -> None:
        block_planes(
            block.start,
            block.stop,
            grid.begins,
            means,
            inner,
            starts,
            near,
            count,
            normals,
            spreads,
        )

    points = np.diff(grid.begins)
    if np.isfinite(quiet) and m > 2 * _RUN * _RUNS:
        runs = np.linspace(0, m - _RUN, _RUNS).astype(np.int64)
        for first in runs.tolist():
            work(slice(first, first + _RUN))
        some = (runs[:, None] + np.arange(_RUN)).ravel()
        flat = spreads[some, 0] / np.maximum(spreads[some].sum(axis=1), 1e-300)
        if float(np.median(np.repeat(flat, points[some]))) > _BY_FAR * quiet:
            return None
    run_in_blocks(work, m, progress, _BLOCK)
    area, variation, noise = np.empty(m), np.empty(m), np.empty(m)
    cell_figures(
        grid.begins, count, inner, spreads, _FEWEST_WITHIN, _THIN, normals, area, variation, noise
    )
    return Elements(
        "cell",
        np.zeros(3),
        means,
        normals,
        area * points,
        inner,
        variation,
        np.sqrt(area),
        noise,
        starts,
        near,
        np.arange(m),
        np.arange(m),
    ), count
