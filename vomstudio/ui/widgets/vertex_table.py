"""Editable table of the vertices that a tool is picking."""

from __future__ import annotations

from typing import Any

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QKeySequence, QShortcut
from PySide6.QtWidgets import QAbstractItemView, QHeaderView, QTableWidget, QTableWidgetItem

from vomstudio.core.findings import Finding
from vomstudio.geometry import transform
from vomstudio.geometry.coordinate_limits import check_coordinates, check_near_model
from vomstudio.geometry.matrices import Matrix
from vomstudio.geometry.units import UNPLACED_AXES
from vomstudio.project.records import Model, get
from vomstudio.studio.tools.polyline import PolylineTool
from vomstudio.ui.base.numbers import parse_number
from vomstudio.ui.base.studio import Studio


class VertexTable(QTableWidget):
    """Table of the World coordinates of a tool's vertices, visible while the tool picks."""

    def __init__(self, studio: Studio, tool: PolylineTool[Any]) -> None:
        super().__init__(0, 3)
        self._studio = studio
        self._tool = tool
        self.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.horizontalHeader().setMinimumSectionSize(40)
        self.verticalHeader().setFixedWidth(22)
        self.verticalHeader().setDefaultSectionSize(22)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setMinimumHeight(76)
        self.itemSelectionChanged.connect(self._select_vertex)
        self.itemChanged.connect(self._cell_edited)
        delete = QShortcut(QKeySequence.StandardKey.Delete, self)
        delete.setContext(Qt.ShortcutContext.WidgetShortcut)
        # The vertex in the current row is marked.
        delete.activated.connect(tool.delete_vertex)

    def _model(self) -> Model | None:
        feature = self._tool.feature
        return get(self._studio.records, feature.model_id, Model) if feature else None

    def _to_world(self) -> Matrix | None:
        model = self._model()
        return None if model is None else model.to_world

    def refresh(self) -> None:
        """Show the current vertices of the tool."""
        tool = self._tool
        model = self._model()
        self.setHorizontalHeaderLabels(
            (UNPLACED_AXES if model is None else model.frame.axes).titles
        )
        with QSignalBlocker(self):
            self.setRowCount(len(tool.vertices))
            if tool.vertices:
                rows = self._to_world()
                points = transform.apply(rows, tool.vertices) if rows else tool.vertices
                for i, point in enumerate(points):
                    for j, value in enumerate(point):
                        item = QTableWidgetItem(f"{value:.3f}")
                        item.setTextAlignment(
                            Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
                        )
                        self.setItem(i, j, item)
            if tool.current_vertex is not None:
                # Keep the clicked cell of the row current.
                self.setCurrentCell(tool.current_vertex, max(self.currentColumn(), 0))
            else:
                self.clearSelection()
                self.scrollToBottom()
        self.setVisible(tool.is_open)

    def _select_vertex(self) -> None:
        rows = {index.row() for index in self.selectedIndexes()}
        if rows and self._tool.is_open:
            self._tool.mark(rows.pop())

    def _cell_edited(self, item: QTableWidgetItem) -> None:
        """Move a vertex to a typed coordinate, which may have either decimal mark."""
        tool = self._tool
        if not tool.is_open:
            return
        rows = self._to_world()
        value = parse_number(item.text())
        if value is None:
            self._studio.warn(Finding("number.invalid", text=item.text()))
            self.refresh()
            return
        index = item.row()
        position = (
            transform.apply(rows, [tool.vertices[index]])[0] if rows else tool.vertices[index]
        )
        point = [float(v) for v in position]
        point[item.column()] = value
        if rows:
            point = [float(v) for v in transform.apply(transform.invert(rows), [point])[0]]
        if (finding := self._position_problem(point)) is not None:
            self._studio.warn(finding)
            self.refresh()
            return
        tool.move_vertex(index, (point[0], point[1], point[2]))

    def _position_problem(self, point: list[float]) -> Finding | None:
        """Return a finding if a point (file frame) cannot be on the model, otherwise None."""
        model = self._model()
        open_model = None if model is None else self._studio.models.get(model.id)
        if open_model is None:
            return check_coordinates(point)
        return check_near_model(point, open_model.data.bounds)
