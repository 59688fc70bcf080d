"""Table of control points: use, coordinates and residuals."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from PySide6.QtCore import QModelIndex, QPersistentModelIndex, QRectF, QSignalBlocker, Qt
from PySide6.QtGui import QColor, QIcon, QPainter
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableWidget,
    QTableWidgetItem,
)

from vomstudio.core.words import tr
from vomstudio.project.kinds.control_point import ControlPoint
from vomstudio.ui.base import theme

if TYPE_CHECKING:
    from vomstudio.registration.results import ModelPlacement, PointResidual

TICK, LABEL = 0, 1
_X_COLUMN, _Z_COLUMN, _RESIDUAL_COLUMN = 2, 4, 5
_SHARE_ROLE = Qt.ItemDataRole.UserRole
_BAR_COLOR, _BLUNDER_COLOR = "#56b4e9", "#d55e00"
_READ_ONLY = Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable


class ControlTable(QTableWidget):
    """Table with one row per point; its last column shows the residual with a bar."""

    def __init__(self) -> None:
        super().__init__(0, _RESIDUAL_COLUMN + 1)
        self.setObjectName("control_points")
        self.setHorizontalHeaderLabels(
            [tr("Use"), tr("Label"), "x (m)", "y (m)", "z (m)", tr("Resid. (m)")]
        )
        self.verticalHeader().hide()
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setItemDelegateForColumn(_RESIDUAL_COLUMN, _BarDelegate(self))
        header = self.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(_RESIDUAL_COLUMN, QHeaderView.ResizeMode.Stretch)
        # Only visible rows are measured.
        header.setResizeContentsPrecision(0)
        header.setMinimumSectionSize(34)
        self.verticalHeader().setDefaultSectionSize(23)
        self.setMinimumHeight(170)
        for column, tooltip in (
            (TICK, tr("Ticked points register the model; the others check it.")),
            (_RESIDUAL_COLUMN, tr("Length of the residual (fitted minus given).")),
        ):
            item = self.horizontalHeaderItem(column)
            if item is not None:
                item.setToolTip(tooltip)
        self._cells: list[list[QTableWidgetItem]] = []

    def choose_row(self, row: int) -> None:
        """Select a row without changing the current column."""
        self.setCurrentCell(row, max(self.currentColumn(), 0))

    def coordinates(self, row: int) -> list[str]:
        """Return the texts of x, y and z in a row."""
        return [cell.text() for cell in self._cells[row][_X_COLUMN : _Z_COLUMN + 1]]

    def show_points(self, points: list[ControlPoint]) -> None:
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        with QSignalBlocker(self):
            self.setRowCount(len(points))
        self._cells = []
        with self._resize_columns_once():
            for row, point in enumerate(points):
                tick = QTableWidgetItem()
                tick.setFlags(_READ_ONLY | Qt.ItemFlag.ItemIsUserCheckable)
                tick.setCheckState(
                    Qt.CheckState.Unchecked if point.check else Qt.CheckState.Checked
                )
                coordinates = (
                    [""] * 3 if point.position is None else [f"{v:.3f}" for v in point.position]
                )
                residual = QTableWidgetItem()
                residual.setFlags(_READ_ONLY)
                numbers = [*map(QTableWidgetItem, coordinates), residual]
                for item in numbers:
                    item.setTextAlignment(right)
                self._cells.append([tick, QTableWidgetItem(point.name), *numbers])
                for column, item in enumerate(self._cells[-1]):
                    self.setItem(row, column, item)

    def show_residuals(self, points: list[ControlPoint], placement: ModelPlacement | None) -> None:
        residuals: dict[str, PointResidual] = {}
        blunders: set[str] = set()
        if placement is not None:
            residuals = {p.label: p for p in (*placement.control, *placement.check)}
            blunders = {blunder.label for blunder in placement.blunders}
        largest_error = max((p.error_m for p in residuals.values()), default=0.0)
        alert_icon = theme.icon("alert-outline")
        with self._resize_columns_once():
            for cells, point in zip(self._cells, points, strict=True):
                item, residual = cells[_RESIDUAL_COLUMN], residuals.get(point.name)
                if residual is not None:
                    item.setText(f"{residual.error_m:.3f}")
                    item.setToolTip(
                        f"dx {residual.dx:.3f}, dy {residual.dy:.3f}, dz {residual.dz:.3f} m"
                    )
                else:
                    item.setText("" if point.vertices else tr("not found"))
                    item.setToolTip("")
                bar_share = (
                    residual.error_m / largest_error
                    if residual is not None and largest_error > 0.0
                    else 0.0
                )
                item.setData(_SHARE_ROLE, -bar_share if point.name in blunders else bar_share)
                cells[LABEL].setIcon(alert_icon if point.name in blunders else QIcon())

    @contextmanager
    def _resize_columns_once(self) -> Iterator[None]:
        """Resize the columns once after all cells have changed.

        Resizing them after each cell would take minutes for a thousand points.
        """
        with QSignalBlocker(self), QSignalBlocker(self.model()):
            yield
        for column in range(_RESIDUAL_COLUMN):
            self.resizeColumnToContents(column)
        self.viewport().update()


class _BarDelegate(QStyledItemDelegate):
    """Delegate that draws a bar behind a number.

    The bar length is a fraction of the longest bar; a negative fraction marks a blunder.
    """

    def paint(
        self,
        painter: QPainter,
        option: QStyleOptionViewItem,
        index: QModelIndex | QPersistentModelIndex,
    ) -> None:
        bar_share = float(index.data(_SHARE_ROLE) or 0.0)
        if bar_share:
            color = QColor(_BLUNDER_COLOR if bar_share < 0.0 else _BAR_COLOR)
            color.setAlphaF(0.45)
            box = QRectF(option.rect).adjusted(1.0, 3.0, -1.0, -3.0)
            box.setWidth(abs(bar_share) * box.width())
            painter.fillRect(box, color)
        super().paint(painter, option, index)
