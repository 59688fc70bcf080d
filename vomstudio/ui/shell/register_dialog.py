"""Dialog that places a model by a table of points found on it: residuals, and the error in degrees,
as each point is ticked as control or left to judge."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QIcon
from PySide6.QtWidgets import (
    QAbstractItemView,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFormLayout,
    QHeaderView,
    QLabel,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from vomstudio.document import edits
from vomstudio.document.records import Model
from vomstudio.errors import VomError
from vomstudio.io.control.observation_tables import Pairs
from vomstudio.registration.results import Placed
from vomstudio.ui.common import file_filters, theme
from vomstudio.ui.common.command_targets import current_model, start_folder
from vomstudio.ui.common.crs_field import CrsField
from vomstudio.ui.common.explained import explain
from vomstudio.ui.common.long_boxes import fit_to_screen
from vomstudio.ui.common.studio import Studio
from vomstudio.words import tr

_COLUMNS = 6


def register_by_points(parent: QWidget, studio: Studio) -> None:
    """Ask for a table of points on the current model, and show what it gives."""
    from vomstudio.io.control.observation_tables import read_pairs

    model = current_model(studio)
    if model is None:
        return
    name, _ = QFileDialog.getOpenFileName(
        parent,
        tr("Points on {model}", model=model.name),
        start_folder(studio),
        file_filters.tables(),
    )
    if not name:
        return
    try:
        pairs = read_pairs(name)
    except VomError as error:
        studio.warn(str(error), "error")
        return
    dialog = RegisterDialog(parent, model, pairs, Path(name).name)
    dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    dialog.accepted.connect(partial(_apply, studio, dialog))
    studio.project_opened.connect(dialog.close)
    fit_to_screen(dialog)
    # The model that it places stays the chosen one while it is open.
    dialog.open()


def _apply(studio: Studio, dialog: RegisterDialog) -> None:
    from vomstudio.workspace.registering import registration_of, turned_deg

    before = studio.records.get(dialog.model.id)
    placed = dialog.placed
    if not isinstance(before, Model) or placed is None:
        return
    record = registration_of(placed, dialog.pairs, before, dialog.crs)
    if not studio.attempt(edits.set_registration, record, [before.id]):
        return
    after = studio.records[before.id]
    assert isinstance(after, Model)
    studio.warn(
        tr(
            "{model} was placed by {count} points; it turned by {turn:.1f} degrees, and what was "
            "measured on it with it.",
            model=before.name,
            count=len(placed.control),
            turn=turned_deg(before, after),
        ),
        "info",
    )


class RegisterDialog(QDialog):
    """`placed` is the placement by the points that are ticked, None where they give none; `pairs`
    are the points with these ticks, `crs` that of their coordinates or None."""

    def __init__(self, parent: QWidget, model: Model, pairs: Pairs, file: str) -> None:
        super().__init__(parent)
        explain(self, "registration.md")
        self.setWindowTitle(tr("Register {model}", model=model.name))
        self.model, self.pairs = model, pairs
        self.placed: Placed | None = None
        self.crs: str | None = None
        intro = QLabel(
            tr(
                "Ticked points of {file} place the model; the others judge it. Residuals are "
                "fitted less given.",
                file=file,
            )
        )
        intro.setWordWrap(True)
        self.table = QTableWidget(len(pairs.labels), _COLUMNS)
        self._ticks: list[QTableWidgetItem] = []
        self._cells: list[list[QTableWidgetItem]] = []
        self._fill_table()
        self.field = CrsField(model.frame.crs or "")
        self.field.setPlaceholderText(tr("none: local metres, x east, y north"))
        self.said = QLabel()
        self.said.setWordWrap(True)
        self.said.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel
        )
        self.buttons.button(QDialogButtonBox.StandardButton.Ok).setText(tr("Register"))
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        form = QFormLayout()
        form.addRow(tr("CRS of x, y, z"), self.field)
        layout = QVBoxLayout(self)
        layout.addWidget(intro)
        layout.addWidget(self.table, 1)
        layout.addLayout(form)
        layout.addWidget(self.said)
        layout.addWidget(self.buttons)
        self.resize(640, 520)
        self.table.itemChanged.connect(self._ticked)
        self.field.textChanged.connect(self._solve)
        self._solve()

    def _fill_table(self) -> None:
        self.table.setHorizontalHeaderLabels(
            [tr("Control"), tr("Label"), "dx (m)", "dy (m)", "dz (m)", tr("Residual (m)")]
        )
        self.table.verticalHeader().hide()
        self.table.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        header = self.table.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setSectionResizeMode(1, QHeaderView.ResizeMode.Stretch)
        for row, label in enumerate(self.pairs.labels):
            tick = QTableWidgetItem()
            tick.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsUserCheckable)
            used = not self.pairs.check[row]
            tick.setCheckState(Qt.CheckState.Checked if used else Qt.CheckState.Unchecked)
            self.table.setItem(row, 0, tick)
            self._ticks.append(tick)
            self._cells.append([])
            for column in range(1, _COLUMNS):
                item = QTableWidgetItem(label if column == 1 else "")
                item.setFlags(Qt.ItemFlag.ItemIsEnabled)
                if column > 1:
                    item.setTextAlignment(
                        Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
                    )
                self.table.setItem(row, column, item)
                self._cells[-1].append(item)

    def _ticked(self, item: QTableWidgetItem) -> None:
        if item.column() == 0:
            self._solve()

    def _solve(self) -> None:
        """Place the model anew by what is ticked, and say what that is worth."""
        from vomstudio.registration.evidence import Evidence, register

        judging = [tick.checkState() != Qt.CheckState.Checked for tick in self._ticks]
        self.pairs = replace(self.pairs, check=np.array(judging, bool))
        self.placed = None
        try:
            self.crs = self._typed_crs()
            placed = register(Evidence(pairs=self.pairs))
        except VomError as error:
            self.said.setText(error.message)
        else:
            self.placed = placed
            self.said.setText(_in_words(placed))
        self._show_residuals()
        ok = self.buttons.button(QDialogButtonBox.StandardButton.Ok)
        ok.setEnabled(self.placed is not None)
        ok.setToolTip("" if self.placed is not None else self.said.text())

    def _typed_crs(self) -> str | None:
        from vomstudio.io.gis.crs import metric_crs

        text = self.field.text().strip()
        return metric_crs(text, tr("CRS of x, y, z")) if text else None

    def _show_residuals(self) -> None:
        known = () if self.placed is None else (*self.placed.control, *self.placed.check)
        left = {point.label: point for point in known}
        wrong = set() if self.placed is None else {b.label for b in self.placed.blunders}
        self.table.blockSignals(True)
        for row, label in enumerate(self.pairs.labels):
            point = left.get(label)
            values = (
                ("", "", "", "")
                if point is None
                else tuple(f"{v:.3f}" for v in (point.dx, point.dy, point.dz, point.error_m))
            )
            self._cells[row][0].setIcon(theme.icon("alert-outline") if label in wrong else QIcon())
            for item, text in zip(self._cells[row][1:], values, strict=True):
                item.setText(text)
        self.table.blockSignals(False)


def _in_words(placed: Placed) -> str:
    """What a geologist must know of it."""
    from vomstudio.registration.remarks import said_of_worst

    said = []
    if placed.rms_control_m is not None:
        said.append(
            tr(
                "Control points: {control:.3f} m (RMS).",
                control=placed.rms_control_m,
            )
        )
    if placed.rms_check_m is not None:
        said.append(tr("Check points: {check:.3f} m (RMS).", check=placed.rms_check_m))
    said += said_of_worst(placed)
    # What is wrong with a point is read first.
    return "\n".join([*reversed(placed.warnings), " ".join(said)])
