"""The grids of what was looked at, as a layer: a ring for each cell, with what was found there."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray, ObjectArray
from vomstudio.geology.coverage.cells import CellGrid
from vomstudio.geology.coverage.face_coverage import DONE, EMPTY, OPEN, TITLES, UNMEASURABLE
from vomstudio.geometry import transform
from vomstudio.project.grid_edits import marks_of
from vomstudio.project.measurement import rows_of
from vomstudio.project.records import FaceGrid, Model, Record, get

LAYER = "looked_at"
COLORS = {OPEN: "#bdbdbd", DONE: "#009e73", EMPTY: "#f0e442", UNMEASURABLE: "#202020"}


def file_grid(grid: FaceGrid) -> CellGrid:
    """In the model's file frame."""
    return CellGrid(
        np.array(grid.origin),
        np.array(grid.right),
        np.array(grid.up),
        grid.cell,
        grid.columns,
        grid.rows,
    )


def cells_in_world(
    grid: FaceGrid, records: Mapping[str, Record], marks: str | None = None
) -> tuple[IntArray, FloatArray]:
    """(n,) numbers and (n, 4, 3) corners of cells in World; marks : only of cells with one of these
    letters"""
    found = marks_of(grid)
    chosen = [i for i, mark in enumerate(found) if marks is None or mark in marks]
    numbers = np.array(chosen, np.int64)
    corners = file_grid(grid).corners(numbers).reshape(-1, 3)
    rows = rows_of(get(records, grid.model_id, Model))
    return numbers, transform.apply(rows, corners).reshape(-1, 4, 3)


def grid_cells(
    records: Mapping[str, Record],
) -> tuple[list[FloatArray], dict[str, ObjectArray], list[str]]:
    """Rings, columns and colours of all cells of the project's grids."""
    shapes: list[FloatArray] = []
    rows: list[tuple[str, str, str, str, str, str]] = []
    colors: list[str] = []
    for grid in records.values():
        if not isinstance(grid, FaceGrid):
            continue
        model = get(records, grid.model_id, Model)
        marks = marks_of(grid)
        numbers, corners = cells_in_world(grid, records)
        shapes += list(corners)
        for number in numbers.tolist():
            row, column = divmod(number, grid.columns)
            place = f"{column + 1}, {row + 1}"
            found, colour = TITLES[marks[number]], COLORS[marks[number]]
            of = "" if model is None else model.name
            rows.append((grid.id, grid.name, place, found, of, grid.notes))
            colors.append(colour)
    names = ("id", "name", "cell", "found", "model", "notes")
    columns = zip(*rows, strict=True) if rows else ((),) * len(names)
    table = {n: np.array(words, object) for n, words in zip(names, columns, strict=True)}
    return shapes, table, colors
