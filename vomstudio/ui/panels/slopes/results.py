"""Table of the failure modes of a slope, and list of the critical planes for one mode."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QBoxLayout,
    QHBoxLayout,
    QHeaderView,
    QListWidget,
    QListWidgetItem,
    QSizePolicy,
    QSpacerItem,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.words import to_translate, tr, tr_n
from vomstudio.ui.base.controls import MAX_FORM_WIDTH_PX, Label

if TYPE_CHECKING:
    from vomstudio.geology.table_slopes import CriticalPlane, FailureMode
    from vomstudio.ui.panels.slopes.analysis import FaceSlopeResult

_MODES = (
    ("planar", to_translate("Planar sliding"), True),
    ("wedge", to_translate("Wedge sliding"), False),
    ("flexural_toppling", to_translate("Flexural toppling"), True),
    ("direct_toppling", to_translate("Direct toppling"), False),
    ("bases", to_translate("Toppling bases"), True),
)
"""Name and title of each failure mode, and whether it counts planes or intersections."""
_COLUMNS = (
    (to_translate("Mode"), to_translate("Click a mode to list its critical planes.")),
    (to_translate("Critical"), to_translate("Planes or intersections in the critical zone.")),
    (to_translate("Total"), to_translate("All planes, or all intersections of two planes.")),
    (to_translate("Share"), to_translate("Critical planes or intersections as a share of all.")),
    (
        to_translate("Expected"),
        to_translate("Expected share if the error of each plane is included."),
    ),
)
_LIST_HEIGHT_PX = 90
_LIST_WIDTH_PX = 145
_MAX_WIDGET_WIDTH_PX = 16_777_215
_MIN_SIDE_BY_SIDE_PX = 440
"""Minimum width for listing the planes beside the table instead of below it."""


class SlopeResults(QWidget):
    """Widget with failure modes and critical planes.

    `planes_clicked` is emitted with the ids of clicked planes.
    """

    planes_clicked = Signal(object)

    def __init__(self) -> None:
        super().__init__()
        self._result: FaceSlopeResult | None = None
        self.table = _mode_table()
        self.table.itemSelectionChanged.connect(self._list_planes)
        self.heading = Label()
        self.heading.setWordWrap(True)
        self.planes = QListWidget()
        self.planes.setAccessibleName(tr("Critical planes"))
        self.planes.setUniformItemSizes(True)
        self.planes.setMinimumHeight(_LIST_HEIGHT_PX)
        self.planes.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Ignored)
        self.planes.setSelectionMode(QAbstractItemView.SelectionMode.ExtendedSelection)
        self.planes.itemSelectionChanged.connect(self._emit_clicked_planes)
        self._side_layout = QHBoxLayout()
        self._side_layout.setSpacing(4)
        self._side_layout.addWidget(self.table, 1, Qt.AlignmentFlag.AlignTop)
        self._side_layout.addWidget(self.planes)
        self._spacer = QSpacerItem(0, 0)
        self._side_layout.addSpacerItem(self._spacer)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(2)
        column.addWidget(self.heading)
        column.addLayout(self._side_layout, 1)
        self.show_result(None)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        super().resizeEvent(event)
        is_wide = self.width() >= _MIN_SIDE_BY_SIDE_PX
        direction = QBoxLayout.Direction
        self._side_layout.setDirection(direction.LeftToRight if is_wide else direction.TopToBottom)
        self.planes.setMaximumWidth(_LIST_WIDTH_PX if is_wide else _MAX_WIDGET_WIDTH_PX)
        # Figures far to the right of their names could not be read.
        self.table.setMaximumWidth(MAX_FORM_WIDTH_PX if is_wide else _MAX_WIDGET_WIDTH_PX)
        policy = QSizePolicy.Policy.Expanding if is_wide else QSizePolicy.Policy.Minimum
        self._spacer.changeSize(0, 0, policy, QSizePolicy.Policy.Minimum)
        self._side_layout.invalidate()

    @property
    def mode(self) -> str:
        """Name of the failure mode whose planes are listed."""
        return _MODES[max(self.table.currentRow(), 0)][0]

    def critical_ids(self) -> list[str]:
        """Return the ids of the listed planes."""
        return [plane.id for plane in self._list_critical_planes()]

    def show_result(self, result: FaceSlopeResult | None, notation: str = "dipdir/dip") -> None:
        """Show a result; None clears the table."""
        self._result, self._notation = result, notation
        for row, (name, _, _) in enumerate(_MODES):
            cells = [""] * 4 if result is None else _cell_texts(_mode(result, name))
            for column, text in enumerate(cells, 1):
                item = self.table.item(row, column)
                assert item is not None
                item.setText(text)
        self._list_planes()

    def mark(self, ids: tuple[str, ...]) -> None:
        """Select the listed planes that have these ids, without emitting a signal."""
        selected_ids = set(ids)
        with QSignalBlocker(self.planes):
            for row in range(self.planes.count()):
                item = self.planes.item(row)
                is_selected = item.data(Qt.ItemDataRole.UserRole) in selected_ids
                if is_selected != item.isSelected():
                    item.setSelected(is_selected)

    def _list_critical_planes(self) -> tuple[CriticalPlane, ...]:
        return () if self._result is None else self._result.critical[self.mode]

    def _list_planes(self) -> None:
        """List the critical planes of the selected mode."""
        critical_planes = self._list_critical_planes()
        with QSignalBlocker(self.planes):
            self.planes.clear()
            for plane in critical_planes:
                item = QListWidgetItem(self._plane_text(plane))
                item.setToolTip(item.text())
                item.setData(Qt.ItemDataRole.UserRole, plane.id)
                self.planes.addItem(item)
        self.planes.setVisible(bool(critical_planes))
        self.heading.setVisible(self._result is not None)
        self.heading.setText(self._heading(len(critical_planes)))

    def _heading(self, count: int) -> str:
        _, title, counts_planes = next(entry for entry in _MODES if entry[0] == self.mode)
        mode = tr(title).removeprefix("– ")
        if not count:
            return tr("{mode}: no plane is critical.", mode=mode)
        if counts_planes:
            return tr_n(
                "{mode}: {count:,} critical plane. Click to select it.",
                "{mode}: {count:,} critical planes. Click to select one.",
                count,
                mode=mode,
            )
        return tr(
            "{mode}: {count:,} planes, sorted by their number of critical intersections.",
            count=count,
            mode=mode,
        )

    def _plane_text(self, critical_plane: CriticalPlane) -> str:
        assert self._result is not None
        request = self._result.request
        feature = request.records[critical_plane.id]
        measurement = request.measured[critical_plane.id]
        name = getattr(feature, "name", "") or critical_plane.id
        text = f"{name}  {measurement.attitude(self._notation)}"
        return (
            text
            if critical_plane.intersections is None
            else f"{text}  ({critical_plane.intersections:,})"
        )

    def _emit_clicked_planes(self) -> None:
        self.planes_clicked.emit(
            [i.data(Qt.ItemDataRole.UserRole) for i in self.planes.selectedItems()]
        )


def _mode_table() -> QTableWidget:
    table = QTableWidget(len(_MODES), len(_COLUMNS))
    table.setAccessibleName(tr("Failure modes"))
    for column, (title, tooltip) in enumerate(_COLUMNS):
        header_item = QTableWidgetItem(tr(title))
        header_item.setToolTip(tr(tooltip))
        table.setHorizontalHeaderItem(column, header_item)
    for row, (_, title, _) in enumerate(_MODES):
        for column in range(len(_COLUMNS)):
            item = QTableWidgetItem(tr(title) if column == 0 else "")
            if column:
                item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            table.setItem(row, column, item)
    table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
    table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
    table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
    table.setTabKeyNavigation(False)
    table.setAlternatingRowColors(True)
    table.verticalHeader().hide()
    row_height = table.fontMetrics().height() + 8
    table.verticalHeader().setDefaultSectionSize(row_height)
    header = table.horizontalHeader()
    header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
    header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
    table.setCurrentCell(0, 0)
    height = header.sizeHint().height() + len(_MODES) * row_height + 2 * table.frameWidth()
    table.setFixedHeight(height)
    table.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    return table


def _mode(result: FaceSlopeResult, name: str) -> FailureMode:
    analysis = result.analysis
    modes: Mapping[str, FailureMode] = {
        "planar": analysis.planar,
        "wedge": analysis.wedge,
        "flexural_toppling": analysis.flexural_toppling,
        "direct_toppling": analysis.direct_toppling,
        "bases": analysis.direct_toppling.bases,
    }
    return modes[name]


def _cell_texts(mode: FailureMode) -> list[str]:
    share_texts = [
        "–" if s is None else f"{100.0 * s:.1f} %" for s in (mode.share, mode.probability)
    ]
    return [f"{mode.critical:,}", f"{mode.of:,}", *share_texts]
