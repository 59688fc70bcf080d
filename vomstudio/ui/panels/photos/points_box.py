"""List of points, form of the selected point, and findings about missing points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import isfinite

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QAbstractItemView,
    QFormLayout,
    QGridLayout,
    QGroupBox,
    QHBoxLayout,
    QHeaderView,
    QLineEdit,
    QTableWidget,
    QTableWidgetItem,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.coordinate_limits import check_coordinates
from vomstudio.io.control.points import ControlPoint
from vomstudio.io.text.rows import parse_number
from vomstudio.photogrammetry.georeferencing.mark_prediction import (
    CHECK,
    CONTROL,
    MAX_GOOD_RESIDUAL_PX,
    TIE,
)
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ComboBox, DoubleSpinBox, Label, escape_markup, set_enabled
from vomstudio.ui.base.texts import format_sentence
from vomstudio.ui.panels.photos.mark_canvas import COLORS
from vomstudio.ui.panels.photos.photo_marks import PhotoMarks


class PointsBox(QGroupBox):
    """Box with the points, and with the coordinates and mark of the selected point.

    Attributes
    ----------
    point_selected : Signal
        Emitted with the label of the selected point, or an empty string if none is selected.
    message : Signal
        Emitted with a message for the user and its level.
    mark_edited : Signal
        Emitted with the position (x, y) of the point's mark in pixels of the stored open photo.
    """

    point_selected = Signal(str)
    message = Signal(object, str)
    mark_edited = Signal(float, float)

    def __init__(self, marks: PhotoMarks) -> None:
        super().__init__(tr("Points"))
        self._marks = marks
        self.label = ""
        self.photo = ""
        self._labels: tuple[str, ...] = ()
        self._buttons: dict[str, QToolButton] = {}
        self.table = self._make_table()
        self.missing_label = Label()
        self.missing_label.setObjectName("missing")
        self.missing_label.setWordWrap(True)
        layout = QVBoxLayout(self)
        layout.setSpacing(6)
        buttons = QGridLayout()
        buttons.setSpacing(4)
        for number, name in enumerate(
            ("new_point", "remove_point", "import_points", "import_marks")
        ):
            button = self._buttons[name] = QToolButton()
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            buttons.addWidget(button, number // 2, number % 2)
        buttons.setColumnStretch(2, 1)
        layout.addLayout(buttons)
        layout.addWidget(self.table, 1)
        layout.addWidget(self._make_form())
        layout.addWidget(self.missing_label)
        marks.changed.connect(self.refresh)
        self.refresh()

    def _make_table(self) -> QTableWidget:
        titles = (tr("Point"), tr("Role"), tr("Photos"), tr("Residual"))
        table = QTableWidget(0, len(titles))
        table.setObjectName("point_table")
        table.setHorizontalHeaderLabels(titles)
        worst_item = QTableWidgetItem(titles[3])
        worst_item.setToolTip(
            tr("Largest distance in pixels between a mark and its predicted position.")
        )
        table.setHorizontalHeaderItem(3, worst_item)
        table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        table.verticalHeader().hide()
        table.verticalHeader().setDefaultSectionSize(table.fontMetrics().height() + 8)
        header = table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        table.setMinimumHeight(110)
        table.itemSelectionChanged.connect(self._select_row)
        return table

    def _make_form(self) -> QWidget:
        self.form = QWidget()
        form = QFormLayout(self.form)
        form.setContentsMargins(0, 0, 0, 0)
        form.setVerticalSpacing(4)
        self.name = QLineEdit()
        self.name.setObjectName("point_name")
        self.name.editingFinished.connect(self._rename)
        self.role = ComboBox()
        self.role.setObjectName("point_role")
        for text, role, tooltip in (
            (tr("control"), CONTROL, tr("Used to register the model.")),
            (tr("check"), CHECK, tr("Not used to register the model, but to check it.")),
            (tr("tie"), TIE, tr("Has no coordinates and only links photos.")),
        ):
            self.role.addItem(theme.swatch(COLORS[role]), text, role)
            self.role.setItemData(self.role.count() - 1, tooltip, Qt.ItemDataRole.ToolTipRole)
        self.role.currentIndexChanged.connect(self._change_role)
        row = QHBoxLayout()
        row.addWidget(self.name, 1)
        row.addWidget(self.role)
        form.addRow(tr("Point"), row)
        self.coordinate_fields = [QLineEdit() for _ in range(4)]
        titles = (tr("East"), tr("North"), tr("Height"), tr("Accuracy"))
        grid = QGridLayout()
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setSpacing(4)
        for number, (field, title) in enumerate(zip(self.coordinate_fields, titles, strict=True)):
            field.setObjectName(("point_x", "point_y", "point_z", "point_sigma")[number])
            field.setPlaceholderText(title)
            field.setToolTip(tr("{coordinate} in metres; empty if unknown.", coordinate=title))
            field.editingFinished.connect(self._change_coordinates)
            grid.addWidget(field, number // 2, number % 2)
        form.addRow(tr("Position"), grid)
        self.mark_x, self.mark_y = DoubleSpinBox(), DoubleSpinBox()
        pixel = QHBoxLayout()
        for spin, name in ((self.mark_x, "mark_x"), (self.mark_y, "mark_y")):
            spin.setObjectName(name)
            spin.setRange(0.0, 1e6)
            spin.setDecimals(2)
            spin.setSingleStep(0.1)
            spin.setKeyboardTracking(False)
            spin.setToolTip(tr("Pixel position in the photo; arrow keys move the mark by 0.1."))
            spin.valueChanged.connect(
                lambda _: self.mark_edited.emit(self.mark_x.value(), self.mark_y.value())
            )
            pixel.addWidget(spin, 1)
        remove = self._buttons["remove_mark"] = QToolButton()
        remove.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
        pixel.addWidget(remove)
        form.addRow(tr("Mark"), pixel)
        return self.form

    def set_actions(self, actions: Mapping[str, QAction]) -> None:
        """Assign actions to the buttons by name."""
        for name, button in self._buttons.items():
            button.setDefaultAction(actions[name])

    # --- display -----------------------------------------------------------------------------
    def refresh(self) -> None:
        """Update the list, the form and the findings."""
        marking = self._marks.marking
        labels = marking.labels
        with QSignalBlocker(self.table):
            if labels != self._labels:
                self._labels = labels
                self.table.setRowCount(len(labels))
            for row, label in enumerate(labels):
                self._fill_row(row, label)
            is_removed = bool(self.label) and self.label not in labels
            if is_removed:
                self.label = ""
            if self.label:
                self.table.selectRow(labels.index(self.label))
            else:
                self.table.clearSelection()
        self._fill_form()
        texts = [finding.message for finding in self._marks.missing_items()]
        if not labels:
            texts = [tr("Import control points, or click in the photo to mark a tie point.")]
        elif self._marks.cameras is None:
            texts = [
                *texts,
                tr("After alignment, two marks of a point predict the others."),
            ]
        elif not texts:
            texts = [tr("All points are complete.")]
        self.missing_label.setText("\n".join(map(format_sentence, texts)))
        if is_removed:
            self.point_selected.emit("")

    def _fill_row(self, row: int, label: str) -> None:
        marking = self._marks.marking
        role, prediction = marking.role(label), self._marks.prediction(label)
        worst_mark = prediction.worst_mark
        cells = (
            label,
            {CONTROL: tr("control"), CHECK: tr("check"), TIE: tr("tie")}[role],
            str(len(marking.of(label))),
            "–" if worst_mark is None else f"{worst_mark[1]:.2f} px",
        )
        for column, text in enumerate(cells):
            item = self.table.item(row, column)
            if item is None:
                item = QTableWidgetItem()
                self.table.setItem(row, column, item)
            item.setText(text)
            if column == 0:
                item.setIcon(theme.swatch(COLORS[role]))
            if column >= 2:
                item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            residual_item = item
        is_inaccurate = worst_mark is not None and worst_mark[1] > MAX_GOOD_RESIDUAL_PX
        residual_item.setIcon(
            theme.icon("alert-outline") if is_inaccurate else theme.verdict_icon(None)
        )
        residual_item.setForeground(theme.error_color() if is_inaccurate else self.palette().text())
        residual_item.setToolTip(
            ""
            if worst_mark is None
            else tr("Largest residual in {photo}", photo=escape_markup(worst_mark[0]))
        )

    def show_photo(self, name: str, width: int, height: int) -> None:
        """Show the mark in this photo, whose stored size is `width` times `height` pixels."""
        self.photo = name
        with QSignalBlocker(self.mark_x), QSignalBlocker(self.mark_y):
            self.mark_x.setMaximum(width)
            self.mark_y.setMaximum(height)
        self._fill_form()

    def _fill_form(self) -> None:
        marking = self._marks.marking
        set_enabled(self.form, None if self.label else Finding("action.no-point"))
        point = marking.point(self.label)
        if not self.name.hasFocus() or not self.name.isModified():
            self.name.setText(self.label)
        with QSignalBlocker(self.role):
            self.role.setCurrentIndex(self.role.findData(marking.role(self.label)))
        values: list[str] = [""] * 4
        if point is not None:
            values = [
                *(f"{v:.4f}".rstrip("0").rstrip(".") for v in point.position),
                "" if point.sigma_m is None else f"{point.sigma_m:g}",
            ]
        for field, value in zip(self.coordinate_fields, values, strict=True):
            if not (field.hasFocus() and field.isModified()):
                field.setText(value)
        pixel = marking.of(self.label).get(self.photo)
        for spin, number in zip((self.mark_x, self.mark_y), pixel or (0.0, 0.0), strict=True):
            with QSignalBlocker(spin):
                spin.setValue(number)
            set_enabled(spin, None if pixel is not None else Finding("action.no-mark"))

    # --- selection and editing ---------------------------------------------------------------
    def select_point(self, label: str) -> None:
        """Select the point with this label; an empty string deselects."""
        if label != self.label:
            self.label = label
            self.refresh()
            self.point_selected.emit(label)

    def _select_row(self) -> None:
        rows = self.table.selectionModel().selectedRows()
        self.select_point(self._labels[rows[0].row()] if rows else "")

    def _rename(self) -> None:
        text, label = self.name.text().strip(), self.label
        self.name.setModified(False)
        if not label or text == label:
            return
        try:
            new_marking = self._marks.marking.rename_point(label, text)
        except GeometryError as error:
            self.message.emit(error, "warning")
            self._fill_form()
            return
        self.label = text
        self._marks.change(tr("Rename {label}", label=label), new_marking)
        self.point_selected.emit(text)

    def _change_role(self) -> None:
        role, label, marking = self.role.currentData(), self.label, self._marks.marking
        point = marking.point(label)
        if not label or role == marking.role(label):
            return
        if point is None:
            self.message.emit(Finding("control.no-coordinates", label=label), "warning")
            self._fill_form()
            self.coordinate_fields[0].setFocus()
            return
        if role == TIE:
            new_marking = marking.remove_coordinates(label)
        else:
            new_marking = marking.set_coordinates(replace(point, check=role == CHECK))
        self._marks.change(tr("Role of {label}", label=label), new_marking)

    def _change_coordinates(self) -> None:
        if not self.label or not any(field.isModified() for field in self.coordinate_fields):
            return
        texts = [field.text().strip() for field in self.coordinate_fields]
        marking, label = self._marks.marking, self.label
        point = marking.point(label)
        if not any(texts[:3]) and point is not None:
            new_marking = marking.remove_coordinates(label)
        else:
            values = [parse_number(text, decimal_comma=True) if text else None for text in texts]
            pairs = zip(texts, values, strict=True)
            invalid = next((t for t, v in pairs if t and (v is None or not isfinite(v))), None)
            if invalid is not None:
                self.message.emit(Finding("number.invalid", text=invalid), "warning")
                return
            x, y, z, sigma = values
            if x is None or y is None or z is None:
                # The other coordinates have not been typed yet.
                return
            if (problem := check_coordinates((x, y, z))) is not None:
                self.message.emit(problem, "warning")
                return
            if sigma is not None and not sigma > 0:
                self.message.emit(Finding("number.not-positive", value=sigma), "warning")
                return
            new_marking = marking.set_coordinates(
                ControlPoint(label, (x, y, z), sigma, point is not None and point.check)
            )
        for field in self.coordinate_fields:
            field.setModified(False)
        self._marks.change(tr("Coordinates of {label}", label=label), new_marking)
