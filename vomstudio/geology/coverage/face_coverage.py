"""Coverage of a face, and counts of features in the inspected area.

A density depends on the area that it refers to: inspected cells without features are part of this
area; cells that were not inspected or are not measurable are not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.words import to_translate
from vomstudio.geology.coverage.cells import SquareGrid

UNINSPECTED_MARK, INSPECTED_MARK, EMPTY_MARK, UNMEASURABLE_MARK = "-", "d", "e", "u"
"""States of a cell: not inspected, features picked, no features, or not measurable (vegetation,
debris, shadow, hole in the model).
"""
MARK_TITLES = {
    UNINSPECTED_MARK: to_translate("not inspected"),
    INSPECTED_MARK: to_translate("done"),
    EMPTY_MARK: to_translate("empty"),
    UNMEASURABLE_MARK: to_translate("unmeasurable"),
}
MIN_COVERED_SHARE = 1e-6


@dataclass(frozen=True)
class CellShare:
    """Number and area of the cells in one state.

    Attributes
    ----------
    cells : int
        Number of cells that contain part of the surface.
    covered_m2 : float
        Area that these cells cover in the view, m2.
    surface_m2 : float
        Surface area within these cells, m2.
    share : float or None
        Share of the covered area of all cells; None if no area is covered.
    """

    cells: int
    covered_m2: float
    surface_m2: float
    share: float | None


@dataclass(frozen=True, repr=False)
class FaceCoverage(PrintableResult):
    """Coverage of a face, that is, the part of it that was inspected.

    Areas are in the squared unit of the grid, which is metres in a project.

    Attributes
    ----------
    not_looked_at, done, empty, unmeasurable : CellShare
        Cells in each state.
    looked_at_share : float or None
        Combined share of the last three states.
    contradictions : tuple of str
        Cells that are marked as empty but contain a feature.
    features : int
        Number of features in cells that are marked as done or empty.
    density_1_per_m2 : float or None
        Feature midpoints in these cells per covered area; None if there are no such cells.
    P21_1_per_m : float or None
        Length of the features in these cells per covered area, in the view; None if there are no
        such cells.
    """

    cells: int
    cell_m: float
    not_looked_at: CellShare
    done: CellShare
    empty: CellShare
    unmeasurable: CellShare
    looked_at_share: float | None
    contradictions: tuple[str, ...]
    features: int
    counted_m2: float
    density_1_per_m2: float | None
    P21_1_per_m: float | None
    reasons: tuple[Finding, ...]


def cell_name(grid: SquareGrid, cell: int) -> str:
    """Return the map name of a cell: A1 is at the upper left, and AA follows Z.

    Parameters
    ----------
    grid : SquareGrid
    cell : int
        Number of the cell in the grid.

    Returns
    -------
    str
    """
    row, column = divmod(int(cell), grid.columns)
    column_name = ""
    column += 1
    while column:
        column, digit = divmod(column - 1, 26)
        column_name = chr(65 + digit) + column_name
    return f"{column_name}{grid.rows - row}"


def measure_coverage(
    grid: SquareGrid,
    marks: str,
    surface: FloatArray,
    covered_areas: FloatArray,
    lines: Sequence[FloatArray] = (),
) -> FaceCoverage:
    """Measure the inspected share of a face and the density of features in it.

    Parameters
    ----------
    grid : SquareGrid
    marks : str
        State of each cell as one letter.
    surface, covered_areas : (cells,) ndarray
        Areas as in `cells.ExposedArea`.
    lines : sequence of (k, 3) ndarray
        Vertices of each feature, or its only point, in the frame of the grid.

    Returns
    -------
    FaceCoverage
    """
    cell_marks = np.array(list(marks.ljust(grid.count, UNINSPECTED_MARK)[: grid.count]))
    has_surface = covered_areas > MIN_COVERED_SHARE * grid.cell**2
    total_area = float(covered_areas[has_surface].sum())

    def cell_share(mark: str) -> CellShare:
        is_selected = has_surface & (cell_marks == mark)
        area = float(covered_areas[is_selected].sum())
        return CellShare(
            int(is_selected.sum()),
            area,
            float(surface[is_selected].sum()),
            area / total_area if total_area > 0 else None,
        )

    shares = {mark: cell_share(mark) for mark in MARK_TITLES}
    is_counted = has_surface & ((cell_marks == INSPECTED_MARK) | (cell_marks == EMPTY_MARK))
    area = float(covered_areas[is_counted].sum())
    lengths = np.zeros(grid.count)
    n_inside = n_midpoints = 0
    contradictory_cells: set[int] = set()
    for line in lines:
        lengths_by_cell = lengths_in_cells(grid, line)
        centre = int(grid.find_cells(_midpoint(line)[None])[0])
        counted_cells = {
            cell for cell, length in lengths_by_cell.items() if is_counted[cell] and length > 0.0
        }
        if centre >= 0 and is_counted[centre]:
            n_midpoints += 1
            counted_cells.add(centre)
        n_inside += bool(counted_cells)
        contradictory_cells |= {
            cell
            for cell in counted_cells
            if cell_marks[cell] == EMPTY_MARK
            and (cell == centre or lengths_by_cell[cell] > 0.05 * grid.cell)
        }
        for cell, length in lengths_by_cell.items():
            lengths[cell] += length
    names = tuple(cell_name(grid, cell) for cell in sorted(contradictory_cells))
    inspected_m2 = total_area - shares[UNINSPECTED_MARK].covered_m2
    return FaceCoverage(
        int(has_surface.sum()),
        grid.cell,
        shares[UNINSPECTED_MARK],
        shares[INSPECTED_MARK],
        shares[EMPTY_MARK],
        shares[UNMEASURABLE_MARK],
        inspected_m2 / total_area if total_area > 0 else None,
        names,
        n_inside,
        area,
        n_midpoints / area if area > 0 else None,
        float(lengths[is_counted].sum()) / area if area > 0 else None,
        tuple(_share_warnings(shares, names, area)),
    )


def lengths_in_cells(grid: SquareGrid, line: FloatArray) -> dict[int, float]:
    """Return the length of a line in each cell of a grid, in the view.

    Parameters
    ----------
    grid : SquareGrid
    line : (k, 3) ndarray

    Returns
    -------
    dict
        Lengths by cell number, in the unit of the grid.
    """
    local_line = grid.local_coordinates(line)[:, :2]
    lengths: dict[int, float] = {}
    for start, end in pairwise(local_line):
        step = end - start
        length = float(np.hypot(*step))
        if not length > 0.0 or not np.isfinite(length):
            continue
        cuts = [np.zeros(1), np.ones(1)]
        for axis, count in ((0, grid.columns), (1, grid.rows)):
            low, high = sorted((start[axis], end[axis]))
            # Only use lines within the grid, because a line may start far outside.
            crossed_grid_lines = np.arange(max(np.ceil(low), 0.0), min(np.floor(high), count) + 1.0)
            if step[axis] != 0.0:
                cuts.append((crossed_grid_lines - start[axis]) / step[axis])
        t = np.unique(np.clip(np.concatenate(cuts), 0.0, 1.0))
        centres = start + ((t[:-1] + t[1:]) / 2.0)[:, None] * step
        cells = grid.numbers(np.floor(centres))
        for cell, fraction in zip(cells.tolist(), np.diff(t).tolist(), strict=True):
            if cell >= 0:
                lengths[cell] = lengths.get(cell, 0.0) + fraction * length * grid.cell
    return lengths


def _midpoint(line: FloatArray) -> FloatArray:
    """Return the point (3,) at half the length of a line."""
    if len(line) == 1:
        return np.asarray(line[0])
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    distances = np.concatenate([[0.0], np.cumsum(steps)])
    return np.array([np.interp(distances[-1] / 2.0, distances, line[:, i]) for i in range(3)])


def _share_warnings(
    shares: dict[str, CellShare], contradictory_cells: tuple[str, ...], counted_area: float
) -> list[Finding]:
    warnings = []
    if (unmeasurable_share := shares[UNMEASURABLE_MARK]).cells:
        warnings.append(
            Finding(
                "grid.unmeasurable-cells",
                count=unmeasurable_share.cells,
                share_percent=100.0 * (unmeasurable_share.share or 0.0),
            )
        )
    if (uninspected_share := shares[UNINSPECTED_MARK]).cells and counted_area > 0.0:
        warnings.append(
            Finding(
                "grid.open-cells",
                count=uninspected_share.cells,
                share_percent=100.0 * (uninspected_share.share or 0.0),
            )
        )
    if contradictory_cells:
        warnings.append(Finding("grid.empty-cells-with-features", cells=contradictory_cells))
    return warnings
