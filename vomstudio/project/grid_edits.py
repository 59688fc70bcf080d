"""Pure functions that create edits of coverage grids."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.project.edit import Edit, change
from vomstudio.project.records import FaceGrid, Model, Record, get

Records = Mapping[str, Record]
MARKS = {"-": "not inspected", "d": "done", "e": "empty", "u": "unmeasurable"}
"""Letters for the state of a cell, with their names in the history."""


def add_grid(records: Records, grid: FaceGrid) -> Edit:
    """Add a grid over a face.

    Raises DocumentError if the model does not exist, the grid already exists, or it is empty.
    """
    if get(records, grid.model_id, Model) is None:
        raise DocumentError(
            Finding("record.missing", kind="model", id=grid.model_id), field="model"
        )
    if grid.id in records:
        raise DocumentError(Finding("record.exists", name=grid.name))
    if not (grid.cell > 0.0 and grid.columns > 0 and grid.rows > 0):
        raise DocumentError(Finding("grid.cell-size"), field="cell")
    if not grid.name:
        grid = replace(grid, name=_next_name(records))
    return change(records, f"Lay grid {grid.name}", {grid.id: grid})


def mark_cells(records: Records, grid_id: str, cells: Iterable[int], mark: str) -> Edit:
    """Set the marks of cells.

    Raises DocumentError if the grid, a cell or the mark does not exist, or if nothing would change.
    """
    grid = _grid(records, grid_id)
    if mark not in MARKS:
        raise DocumentError(
            Finding("option.not-a-choice", value=mark, choices=list(MARKS)), field="mark"
        )
    count = grid.columns * grid.rows
    marks = list(grid_marks(grid))
    selected_cells = sorted(set(cells))
    if not selected_cells or selected_cells[0] < 0 or selected_cells[-1] >= count:
        raise DocumentError(Finding("grid.no-cell", grid=grid.name), field="cells")
    if all(marks[cell] == mark for cell in selected_cells):
        raise DocumentError(Finding("edit.no-change"))
    for cell in selected_cells:
        marks[cell] = mark
    description = "1 cell" if len(selected_cells) == 1 else f"{len(selected_cells)} cells"
    return change(
        records,
        f"Mark {description} as {MARKS[mark]}",
        {grid.id: replace(grid, marks="".join(marks))},
    )


def grid_marks(grid: FaceGrid) -> str:
    """Return one letter per cell; a cell without a valid mark counts as not inspected."""
    count = grid.columns * grid.rows
    known_text = "".join(mark if mark in MARKS else "-" for mark in grid.marks[:count])
    return known_text.ljust(count, "-")


def remove_grid(records: Records, grid_id: str) -> Edit:
    """Remove a coverage grid. Raises DocumentError if it does not exist."""
    grid = _grid(records, grid_id)
    return change(records, f"Remove grid {grid.name}", {grid_id: None})


def _grid(records: Records, grid_id: str) -> FaceGrid:
    grid = get(records, grid_id, FaceGrid)
    if grid is None:
        raise DocumentError(Finding("record.missing", id=grid_id, kind="grid"))
    return grid


def _next_name(records: Records) -> str:
    used_names = {record.name for record in records.values() if isinstance(record, FaceGrid)}
    return next(
        name for k in range(1, len(used_names) + 2) if (name := f"Grid {k}") not in used_names
    )
