"""GIS layer of the coverage grids, with a ring for each cell and its mark."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray, ObjectArray
from vomstudio.geology.coverage.cells import SquareGrid
from vomstudio.geology.coverage.face_coverage import (
    EMPTY_MARK,
    INSPECTED_MARK,
    MARK_TITLES,
    UNINSPECTED_MARK,
    UNMEASURABLE_MARK,
)
from vomstudio.geometry import transform
from vomstudio.project.grid_edits import grid_marks
from vomstudio.project.measurement import matrix_to_world
from vomstudio.project.records import FaceGrid, Model, Record, get

LAYER = "looked_at"
COLORS = {
    UNINSPECTED_MARK: "#bdbdbd",
    INSPECTED_MARK: "#009e73",
    EMPTY_MARK: "#f0e442",
    UNMEASURABLE_MARK: "#202020",
}


def grid_in_file_frame(grid: FaceGrid) -> SquareGrid:
    """Return the cells of a grid in the file frame of the model."""
    return SquareGrid(
        np.array(grid.origin),
        np.array(grid.right),
        np.array(grid.up),
        grid.cell,
        grid.columns,
        grid.rows,
    )


def world_cells(
    grid: FaceGrid, records: Mapping[str, Record], marks: str | None = None
) -> tuple[IntArray, FloatArray]:
    """Return the numbers (n,) and World corners (n, 4, 3) of cells with one of the marks.

    If `marks` is None, all cells are returned.
    """
    cell_marks = grid_marks(grid)
    selected_rows = [i for i, mark in enumerate(cell_marks) if marks is None or mark in marks]
    cell_numbers = np.array(selected_rows, np.int64)
    corners = grid_in_file_frame(grid).corners(cell_numbers).reshape(-1, 3)
    rows = matrix_to_world(get(records, grid.model_id, Model))
    return cell_numbers, transform.apply(rows, corners).reshape(-1, 4, 3)


def grid_cells(
    records: Mapping[str, Record],
) -> tuple[list[FloatArray], dict[str, ObjectArray], list[str]]:
    """Return the rings, columns and colours of all cells of the project's grids."""
    shapes: list[FloatArray] = []
    rows: list[tuple[str, str, str, str, str, str]] = []
    colors: list[str] = []
    for grid in records.values():
        if not isinstance(grid, FaceGrid):
            continue
        model = get(records, grid.model_id, Model)
        marks = grid_marks(grid)
        cell_numbers, corners = world_cells(grid, records)
        shapes += list(corners)
        for cell in cell_numbers.tolist():
            row, column = divmod(cell, grid.columns)
            place = f"{column + 1}, {row + 1}"
            mark_title, colour = MARK_TITLES[marks[cell]], COLORS[marks[cell]]
            model_name = "" if model is None else model.name
            rows.append((grid.id, grid.name, place, mark_title, model_name, grid.notes))
            colors.append(colour)
    names = ("id", "name", "cell", "found", "model", "notes")
    columns = zip(*rows, strict=True) if rows else ((),) * len(names)
    table = {name: np.array(cells, object) for name, cells in zip(names, columns, strict=True)}
    return shapes, table, colors
