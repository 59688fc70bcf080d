"""The panel of the trace tool: vertices, what is made next, the live fit and its reasons."""

from __future__ import annotations

import re

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QAbstractItemView,
    QFormLayout,
    QGridLayout,
    QHeaderView,
    QLabel,
    QLineEdit,
    QSizePolicy,
    QTableWidget,
    QTableWidgetItem,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.document.records import Model
from vomstudio.geometry import transform
from vomstudio.ui.fit_view import FitView
from vomstudio.ui.studio import Studio
from vomstudio.ui.type_box import TypeBox


class TracePanel(QWidget):
    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__()
        self._studio = studio
        self._tool = studio.trace_tool
        self.type_box = TypeBox(studio)
        self.type_box.setObjectName("trace_type")
        self.type_box.currentIndexChanged.connect(self._next_changed)
        self.set_edit = QLineEdit()
        self.set_edit.setPlaceholderText(self.tr("none"))
        self.set_edit.editingFinished.connect(self._next_changed)
        form = QFormLayout()
        form.setContentsMargins(0, 0, 0, 0)
        form.addRow(self.tr("Type"), self.type_box)
        form.addRow(self.tr("Set"), self.set_edit)

        self.fit_view = FitView(reasons_shown=2)

        self.table = QTableWidget(0, 3)
        self.table.setObjectName("trace_vertices")
        self.table.setHorizontalHeaderLabels(["E (m)", "N (m)", "Z (m)"])
        self.table.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.table.horizontalHeader().setMinimumSectionSize(40)
        self.table.verticalHeader().setFixedWidth(22)
        self.table.verticalHeader().setDefaultSectionSize(22)
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.table.setMinimumHeight(76)
        self.table.itemSelectionChanged.connect(self._marked)
        self.table.itemChanged.connect(self._typed)

        buttons = QGridLayout()
        buttons.setSpacing(4)
        names = ("finish", "cancel", "continue_trace", "delete_vertex")
        for i, name in enumerate(names):
            button = QToolButton()
            button.setDefaultAction(actions[name])
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            buttons.addWidget(button, i // 2, i % 2)

        self._hint = QLabel()
        self._hint.setWordWrap(True)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(6, 4, 6, 4)
        layout.setSpacing(4)
        layout.addLayout(form)
        layout.addWidget(self.fit_view)
        layout.addWidget(self.table, 1)
        layout.addWidget(self._hint)
        layout.addLayout(buttons)
        # After the box, which follows them first.
        studio.project_opened.connect(self.refresh)
        studio.edited.connect(self.refresh)
        studio.tool_changed_signal.connect(self.refresh)
        studio.next_changed.connect(self._show_kind)

    def _next_changed(self) -> None:
        self.set_edit.setModified(False)
        self._studio.set_next(str(self.type_box.currentData()), self.set_edit.text().strip())

    def refresh(self, *_: object) -> None:
        tool = self._tool
        measured = tool.measurement if len(tool.vertices) > 2 else None
        self.fit_view.show_measurement(
            measured, self._studio.settings.notation, local=not self._studio.north_known()
        )
        self.fit_view.setVisible(tool.open)
        self._hint.setText(
            ""
            if tool.open
            else self.tr(
                "Choose Trace (T), then click along a bed, fault or fracture. Three points give "
                "a plane; a curved, long trace gives a good one."
            )
        )
        self._hint.setVisible(not tool.open)
        self._show_kind()
        self._fill_vertices()

    def _show_kind(self) -> None:
        """Type and set of the open trace, else of the next one. Those of a continued trace are
        changed in its properties."""
        trace, studio = self._tool.trace, self._studio
        type_id = trace.type_id if trace else studio.next_type_id
        set_name = trace.set_name if trace else studio.next_set
        self.type_box.choose(type_id)
        if not self.set_edit.isModified():
            self.set_edit.setText(set_name)
        for field in (self.type_box, self.set_edit):
            field.setEnabled(not self._tool.continued)
            field.setToolTip(
                self.tr("Not now: a continued trace keeps its type and set; see Properties")
                if self._tool.continued
                else ""
            )

    def _fill_vertices(self) -> None:
        tool = self._tool
        with QSignalBlocker(self.table):
            self.table.setRowCount(len(tool.vertices))
            if tool.open:
                model = self._studio.records.get(tool.trace.model_id) if tool.trace else None
                rows = model.to_world if isinstance(model, Model) else None
                points = transform.apply(rows, tool.vertices) if rows else tool.vertices
                for i, point in enumerate(points):
                    for j, value in enumerate(point):
                        item = QTableWidgetItem(f"{value:.3f}")
                        item.setTextAlignment(
                            Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
                        )
                        self.table.setItem(i, j, item)
                if tool.current_vertex is not None:
                    self.table.selectRow(tool.current_vertex)
                else:
                    self.table.clearSelection()
                    self.table.scrollToBottom()
        self.table.setVisible(tool.open)

    def _marked(self) -> None:
        rows = {index.row() for index in self.table.selectedIndexes()}
        if rows and self._tool.open:
            self._tool.mark(rows.pop())

    def _typed(self, item: QTableWidgetItem) -> None:
        """Numbers may carry either decimal mark."""
        tool = self._tool
        trace = tool.trace
        if trace is None:
            return
        model = self._studio.records.get(trace.model_id)
        rows = model.to_world if isinstance(model, Model) else None
        value = parse_number(item.text())
        if value is None:
            self._studio.warn(f"“{item.text()}” is not a number.")
            self._fill_vertices()
            return
        index = item.row()
        point = transform.apply(rows, [tool.vertices[index]])[0] if rows else tool.vertices[index]
        point = [float(v) for v in point]
        point[item.column()] = value
        if rows:
            point = [float(v) for v in transform.apply(transform.invert(rows), [point])[0]]
        tool.move_vertex(index, (point[0], point[1], point[2]))


def parse_number(text: str) -> float | None:
    """A number with either decimal mark; blanks, apostrophes or the other mark may stand between
    its thousands. One mark alone is the decimal mark."""
    plain = re.sub(r"[\s'’]", "", text).replace("−", "-")
    marks = re.sub(r"[^.,]", "", plain)
    if len(set(marks)) == 2 or len(marks) > 1:
        decimal = marks[-1] if len(set(marks)) == 2 else ""
        group = "." if decimal == "," else "," if decimal == "." else marks[0]
        whole, _, rest = plain.rpartition(decimal) if decimal else (plain, "", "")
        if not re.fullmatch(rf"[+-]?\d{{1,3}}(?:{re.escape(group)}\d{{3}})+", whole):
            return None
        plain = whole.replace(group, "") + "." + rest
    try:
        value = float(plain.replace(",", "."))
    except ValueError:
        return None
    return value if abs(value) < 1e300 else None
