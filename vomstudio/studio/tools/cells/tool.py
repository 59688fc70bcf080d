"""Tool that marks grid cells by a click, or by a key while the cursor is over a cell."""

from __future__ import annotations

import numpy as np

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geology.coverage.cells import SquareGrid
from vomstudio.geology.coverage.face_coverage import (
    INSPECTED_MARK,
    MARK_TITLES,
    UNINSPECTED_MARK,
    cell_name,
)
from vomstudio.geometry import transform
from vomstudio.project import grid_edits
from vomstudio.project.records import FaceGrid, Model, get
from vomstudio.studio.tools.interaction_types import Button, Hit, Pointer, PointerEvent, Preview
from vomstudio.studio.tools.tool_context import ToolContext
from vomstudio.studio.tools.tool_entry import StatelessTool, ToolEntry

_COLOR = (1.0, 1.0, 1.0)


class CellsTool(StatelessTool):
    """Tool that marks the cells of a grid. Each mark is a separate edit.

    Attributes
    ----------
    mark : str
        Mark that the next click sets.
    hovered_cell : (str, int) or None
        Grid and cell under the cursor.
    """

    name = "cells"
    can_paint = False

    def __init__(self, context: ToolContext) -> None:
        self._context = context
        self.mark = INSPECTED_MARK
        self.hovered_cell: tuple[str, int] | None = None

    @property
    def is_open(self) -> bool:
        return False

    def hint(self) -> str:
        if not self._context.session.of(FaceGrid):
            return tr("Cells: create a grid on the face first (Analyse > Coverage).")
        return tr(
            "Cells: click a cell to mark it as {mark} or remove the mark. Q, W, X and Z mark the"
            " cell under the cursor.",
            mark=tr(MARK_TITLES[self.mark]),
        )

    def finish_problem(self) -> Finding | None:
        return Finding("cells.marked-at-once")

    def cancel_problem(self) -> Finding | None:
        return Finding("cells.marked-at-once")

    # --- marks --------------------------------------------------------------------------------
    def mark_hovered_cell(self, mark: str) -> None:
        """Mark the cell under the cursor, and use the same mark for subsequent clicks."""
        self.mark = mark
        if self.hovered_cell is not None:
            self._apply(*self.hovered_cell, mark)
        self._context.tool_changed()

    def pointer(self, event: PointerEvent) -> None:
        if event.kind is Pointer.MOVE:
            self._move(event.hit)
        elif event.kind is Pointer.CLICK and event.button is Button.LEFT:
            # The second click of a double click would remove the mark.
            self._move(event.hit)
            if self.hovered_cell is None:
                self._context.hint(Finding("grid.no-cell"))
                return
            grid_id, cell = self.hovered_cell
            current_mark = self._marks(grid_id)[cell]
            self._apply(grid_id, cell, UNINSPECTED_MARK if current_mark == self.mark else self.mark)

    def _apply(self, grid_id: str, cell: int, mark: str) -> None:
        session = self._context.session
        if self._marks(grid_id)[cell] == mark:
            return
        try:
            session.apply(grid_edits.mark_cells(session.records, grid_id, [cell], mark))
        except DocumentError as error:
            self._context.report(error)
        self._show_preview()

    def _marks(self, grid_id: str) -> str:
        grid = get(self._context.session.records, grid_id, FaceGrid)
        return "" if grid is None else grid_edits.grid_marks(grid)

    def _move(self, hit: Hit | None) -> None:
        cell = None if hit is None else self._find_cell(hit)
        if cell != self.hovered_cell:
            self.hovered_cell = cell
            self._show_preview()

    def _find_cell(self, hit: Hit) -> tuple[str, int] | None:
        """Return the newest grid that has a cell at a hit, and the cell, or None."""
        position = np.array([hit.position])
        for grid in reversed(self._context.session.of(FaceGrid)):
            if grid.model_id == hit.model_id:
                cell = int(_file_grid(grid).find_cells(position)[0])
                if cell >= 0:
                    return grid.id, cell
        return None

    # --- preview ------------------------------------------------------------------------------
    def _show_preview(self) -> None:
        records = self._context.session.records
        grid = None if self.hovered_cell is None else get(records, self.hovered_cell[0], FaceGrid)
        model = None if grid is None else get(records, grid.model_id, Model)
        if grid is None or model is None or self.hovered_cell is None:
            self._context.show(None)
            return
        cells, cell = _file_grid(grid), self.hovered_cell[1]
        corners = transform.apply(model.to_world, cells.corners(np.array([cell]))[0])
        title = tr(MARK_TITLES[grid_edits.grid_marks(grid)[cell]])
        text = tr(
            "{grid}, cell {cell}: {mark}", grid=grid.name, cell=cell_name(cells, cell), mark=title
        )
        self._context.show(Preview(np.zeros((0, 3)), patch=corners, color=_COLOR, reading=(text,)))

    # --- protocol of tools --------------------------------------------------------------------
    def leave(self) -> None:
        self.hovered_cell = None
        self._context.show(None)

    def document_changed(self) -> None:
        if self.hovered_cell is not None:
            if self.hovered_cell[0] not in self._context.session.records:
                self.hovered_cell = None
            self._show_preview()

    def clear_state(self) -> None:
        self.leave()


def _file_grid(grid: FaceGrid) -> SquareGrid:
    return SquareGrid(
        np.array(grid.origin),
        np.array(grid.right),
        np.array(grid.up),
        grid.cell,
        grid.columns,
        grid.rows,
    )


TOOL = ToolEntry(
    CellsTool,
    label=to_translate("&Cells"),
    icon="grid",
    key="Shift+C",
    tip=to_translate("Mark the cells of a grid as done, empty or unmeasurable."),
    order=70,
)
