"""Dialog of the survey planner, with figures from `photogrammetry.survey.planning`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QImage, QPainter
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFormLayout,
    QGridLayout,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.errors import InputError, VomError
from vomstudio.core.findings import Finding, cause_of
from vomstudio.core.words import to_translate, tr
from vomstudio.io.photos.camera_table import find_camera, search_cameras
from vomstudio.photogrammetry.survey.plan_camera import camera_of
from vomstudio.photogrammetry.survey.plan_forecast import add_forecasts
from vomstudio.photogrammetry.survey.planning import MANNERS, SurveyPlan, plan_survey
from vomstudio.photogrammetry.survey.survey_options import (
    DEFAULT_CONTROL_M,
    DEFAULT_RECEIVER_M,
    MAX_OVERLAP,
    MIN_OVERLAP,
    PlanOptions,
)
from vomstudio.products.report.field_sheet import figures, write_field_sheet
from vomstudio.ui.base import file_filters
from vomstudio.ui.base.command_targets import ask_for_target, start_folder
from vomstudio.ui.base.controls import ComboBox, Label, SpinBox, allow
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.numbers import parse_number
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.texts import format_sentence
from vomstudio.ui.dialogs.planner.plan_drawing import PlanDrawing
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey
from vomstudio.ui.widgets.search_field import Match, SearchField

_VIEW_KEY, _JOB_KEY = "survey_plan", "plan"
_TYPING_DELAY_MS = 200
_MANNERS = dict(
    zip(
        MANNERS,
        (
            to_translate("Hand-held camera"),
            to_translate("Drone in front of a cliff"),
            to_translate("Drone over flat ground"),
        ),
        strict=True,
    )
)
# Target quantities: name, key, unit, units per metre, default value.
_TARGETS = (
    (to_translate("Distance to the rock"), "distance_m", "m", 1.0, "30"),
    (to_translate("Ground sampling distance"), "gsd_m", "mm", 1000.0, "10"),
    (to_translate("Smallest plane to measure"), "plane_m", "m", 1.0, "5"),
)
_DEFAULTS = {
    "camera": "",
    "focal": "",
    "aperture": "8",
    "width": "80",
    "height": "25",
    "wish": "distance_m",
    "value": "30",
    "overlap": 70,
    "manner": "handheld",
    "receiver": "",
    "control": "",
}
_PRINT_DPI = 300
_FIELDS = {
    "--width": to_translate("Width of the outcrop"),
    "--height": to_translate("Height of the outcrop"),
    "--distance": to_translate("Distance to the rock"),
    "--gsd": to_translate("Ground sampling distance"),
    "--plane": to_translate("Smallest plane to measure"),
    "--aperture": to_translate("F-number"),
    "--focal": to_translate("Focal length"),
    "--camera": to_translate("Camera"),
    "--overlap": to_translate("Overlap"),
    "--receiver": to_translate("Accuracy of the receiver"),
    "--control": to_translate("Accuracy of the control points"),
}
"""Fields of the dialog, keyed by the option name in planning errors."""
_OPTIONAL = ("focal", "receiver", "control")


class PlannerDialog(QDialog):
    """Dialog that plans a survey while typing. The input is saved with the project."""

    def __init__(self, parent: QWidget, studio: Studio, survey: PhotoSurvey) -> None:
        super().__init__(parent)
        explain(self, "photos.md#planning-a-survey")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Plan photo survey"))
        self.resize(1120, 720)
        self._studio, self._survey = studio, survey
        self._background = QtBackground(self)
        self._request_number = self._shown_number = 0
        self.plan: SurveyPlan | None = None
        self._compute_timer = QTimer(self)
        self._compute_timer.setSingleShot(True)
        self._compute_timer.setInterval(_TYPING_DELAY_MS)
        self._compute_timer.timeout.connect(self._compute)
        self.drawing = PlanDrawing()
        left_column = QWidget()
        left_column.setFixedWidth(430)
        column = QVBoxLayout(left_column)
        column.setContentsMargins(0, 0, 0, 0)
        column.addLayout(self._make_form())
        column.addWidget(self._make_results(), 1)
        columns = QHBoxLayout()
        columns.addWidget(left_column)
        columns.addWidget(self.drawing, 1)
        layout = QVBoxLayout(self)
        layout.addLayout(columns, 1)
        layout.addWidget(self._make_buttons())
        stored_view = studio.project.journal.view(_VIEW_KEY, {})
        is_valid = {
            name: stored_view[name]
            for name, value in _DEFAULTS.items()
            if type(stored_view.get(name)) is type(value)
        }
        self._fill({**_DEFAULTS, **is_valid})
        self._compute()

    # --- widgets -----------------------------------------------------------------------------
    def _make_form(self) -> QFormLayout:
        self.camera = SearchField(_camera_matches)
        self.camera.setObjectName("plan_camera")
        self.camera.setPlaceholderText(tr("Name, or 23.5x15.6,35,6000x4000"))
        self.camera.setToolTip(tr("Choose a camera, or enter sensor, focal length and image size."))
        self.camera.textChanged.connect(self._schedule_plan)
        self.camera.textChanged.connect(self._follow_camera)
        photo = QPushButton(tr("From a photo…"))
        # Enter in a field must not open the file dialog.
        photo.setAutoDefault(False)
        photo.setToolTip(tr("Read camera and focal length from a photo."))
        photo.clicked.connect(self._browse_photo)
        self.focal = self._create_number_field("plan_focal")
        self.focal.setPlaceholderText(tr("Fixed lens"))
        self.aperture = self._create_number_field("plan_aperture")
        self.width_ = self._create_number_field("plan_width")
        self.height_ = self._create_number_field("plan_height")
        self.target = ComboBox()
        self.target.setObjectName("plan_wish")
        for title, key, *_ in _TARGETS:
            self.target.addItem(tr(title), key)
        self.target.currentIndexChanged.connect(self._convert_target)
        self.value = self._create_number_field("plan_value")
        self._unit = Label()
        self.overlap = SpinBox()
        self.overlap.setObjectName("plan_overlap")
        self.overlap.setRange(round(100 * MIN_OVERLAP), round(100 * MAX_OVERLAP))
        self.overlap.setSuffix(" %")
        self.overlap.valueChanged.connect(self._schedule_plan)
        self.manner = ComboBox()
        self.manner.setObjectName("plan_manner")
        for key, title in _MANNERS.items():
            self.manner.addItem(tr(title), key)
        self.manner.currentIndexChanged.connect(self._schedule_plan)
        self.receiver = self._create_number_field("plan_receiver")
        self.receiver.setPlaceholderText(f"{DEFAULT_RECEIVER_M:g}")
        self.receiver.setToolTip(tr("Horizontal error (1σ): 3 m without RTK, 0.02 m with RTK."))
        self.control = self._create_number_field("plan_control")
        self.control.setPlaceholderText(f"{DEFAULT_CONTROL_M:g}")
        self.control.setToolTip(tr("Standard deviation of a control point coordinate."))
        form = QFormLayout()
        form.setVerticalSpacing(6)
        form.addRow(tr("Camera"), _create_row((self.camera, 1), (photo, 0)))
        form.addRow(
            tr("Lens"),
            _create_row((self.focal, 0), (Label(tr("mm   f/")), 0), (self.aperture, 0)),
        )
        form.addRow(
            tr("Outcrop"),
            _create_row(
                (self.width_, 0),
                (Label(tr("m wide")), 0),
                (self.height_, 0),
                (Label(tr("m high")), 0),
            ),
        )
        form.addRow(tr("Method"), self.manner)
        form.addRow(tr("Target"), _create_row((self.target, 0), (self.value, 0), (self._unit, 0)))
        form.addRow(tr("Overlap"), _create_row((self.overlap, 0)))
        form.addRow(
            tr("Accuracy"),
            _create_row(
                (self.receiver, 0),
                (Label(tr("m receiver")), 0),
                (self.control, 0),
                (Label(tr("m control")), 0),
            ),
        )
        return form

    def _create_number_field(self, name: str) -> QLineEdit:
        field = QLineEdit()
        field.setObjectName(name)
        field.setFixedWidth(76)
        field.setAlignment(Qt.AlignmentFlag.AlignRight)
        field.textChanged.connect(self._schedule_plan)
        return field

    def _make_results(self) -> QWidget:
        box = QWidget()
        column = QVBoxLayout(box)
        column.setContentsMargins(0, 8, 0, 0)
        self._grid = QGridLayout()
        self._grid.setColumnStretch(1, 1)
        self._grid.setHorizontalSpacing(14)
        self._grid.setVerticalSpacing(3)
        self.problem = Label()
        self.problem.setObjectName("plan_problem")
        self.problem.setWordWrap(True)
        self.warnings = Label()
        self.warnings.setObjectName("plan_warnings")
        self.warnings.setWordWrap(True)
        column.addWidget(self.problem)
        column.addLayout(self._grid)
        column.addWidget(self.warnings)
        column.addStretch(1)
        self.figures: dict[str, Label] = {}
        return box

    def _make_buttons(self) -> QDialogButtonBox:
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        role = QDialogButtonBox.ButtonRole.ActionRole
        self.save_button = buttons.addButton(tr("Save field sheet…"), role)
        self.print_button = buttons.addButton(tr("Print field sheet…"), role)
        self.save_button.clicked.connect(self._save)
        self.print_button.clicked.connect(self._print)
        for button in buttons.buttons():
            # Enter in a field must not close the dialog.
            if isinstance(button, QPushButton):
                button.setAutoDefault(False)
        buttons.rejected.connect(self.close)
        return buttons

    # --- input -------------------------------------------------------------------------------
    def _fill(self, values: dict[str, Any]) -> None:
        self.camera.setText(str(values["camera"]))
        for field, name in (
            (self.focal, "focal"),
            (self.aperture, "aperture"),
            (self.width_, "width"),
            (self.height_, "height"),
            (self.receiver, "receiver"),
            (self.control, "control"),
        ):
            field.setText(str(values[name]))
        self.target.setCurrentIndex(max(0, self.target.findData(values["wish"])))
        self._show_unit()
        self.value.setText(str(values["value"]))
        self.overlap.setValue(int(values["overlap"]))
        self.manner.setCurrentIndex(max(0, self.manner.findData(values["manner"])))

    def _values(self) -> dict[str, Any]:
        return {
            "camera": self.camera.text().strip(),
            "focal": self.focal.text().strip(),
            "aperture": self.aperture.text().strip(),
            "width": self.width_.text().strip(),
            "height": self.height_.text().strip(),
            "wish": self.target.currentData(),
            "value": self.value.text().strip(),
            "overlap": self.overlap.value(),
            "manner": self.manner.currentData(),
            "receiver": self.receiver.text().strip(),
            "control": self.control.text().strip(),
        }

    def _follow_camera(self, text: str) -> None:
        """Propose a method by drone for the camera of a drone, and by hand for others."""
        model = find_camera(text.strip())
        if model is not None and model.is_drone != (self.manner.currentData() != "handheld"):
            self.manner.setCurrentIndex(
                self.manner.findData("drone" if model.is_drone else "handheld")
            )

    def _convert_target(self) -> None:
        """Convert the target to the newly selected quantity, for the same plan."""
        self._show_unit()
        _, key, _, per_metre, default = _TARGETS[self.target.currentIndex()]
        value = None
        if self.plan is not None:
            value = {
                "distance_m": self.plan.distance_m,
                "gsd_m": self.plan.gsd_m,
                "plane_m": self.plan.smallest_plane_m,
            }[key]
        self.value.setText(default if value is None else f"{value * per_metre:.3g}")
        self._schedule_plan()

    def _show_unit(self) -> None:
        self._unit.setText(_TARGETS[self.target.currentIndex()][2])

    def _browse_photo(self) -> None:
        start = str(self._survey.folder or start_folder(self._studio))
        name, _ = QFileDialog.getOpenFileName(
            self,
            tr("Choose a photo taken with this camera"),
            start,
            file_filters.photos(),
        )
        if name:
            self.focal.clear()
            self.camera.setText(name)

    def _schedule_plan(self, *_: object) -> None:
        self._compute_timer.start()

    # --- results -----------------------------------------------------------------------------
    def _compute(self) -> None:
        values = self._values()
        self._request_number += 1
        number = self._request_number
        self._background.run(
            lambda: _compute_plan(values),
            partial(self._show, number),
            lambda error: self._show(number, None, error),
            key=_JOB_KEY,
        )

    def _show(self, number: int, plan: SurveyPlan | None, error: VomError | None = None) -> None:
        self.plan, self._shown_number = plan, number
        self.problem.setVisible(self.plan is None)
        self.problem.setText("" if error is None else str(error))
        if self.plan is not None:
            self._studio.project.journal.set_view(_VIEW_KEY, self._values())
        self._show_figures([] if self.plan is None else figures(self.plan))
        warnings = () if self.plan is None else self.plan.warnings
        self.warnings.setText("\n".join(f"⚠ {format_sentence(str(text))}" for text in warnings))
        has_fixed_aperture = self.plan is not None and self.plan.camera.f_number is not None
        allow(self.aperture, Finding("action.aperture-fixed") if has_fixed_aperture else None)
        self.drawing.show_plan(self.plan)
        for button in (self.save_button, self.print_button):
            allow(button, None if error is None else cause_of(error))

    def _show_figures(self, rows: list[tuple[str, str]]) -> None:
        if self.plan is not None:
            count, size = len(self.plan.control_points), 100 * self.plan.target_size_m
            checks = sum(point.use == "check" for point in self.plan.control_points)
            # The form above shows these already.
            rows = [row for row in rows if row[0] not in (tr("Outcrop"), tr("Overlap"))]
            control = tr(
                "{count}, including {checks} check points; targets of {size:.2g} cm",
                count=count,
                checks=checks,
                size=size,
            )
            rows = [*rows, (tr("Control points"), control)]
        for name, label in self.figures.items():
            label.setVisible(name in dict(rows))
        while (item := self._grid.takeAt(0)) is not None:
            if (widget := item.widget()) is not None:
                widget.deleteLater()
        self.figures = {}
        for line, (name, value) in enumerate(rows):
            value_label = Label(value)
            value_label.setWordWrap(True)
            value_label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            self._grid.addWidget(Label(name), line, 0, Qt.AlignmentFlag.AlignTop)
            self._grid.addWidget(value_label, line, 1)
            self.figures[name] = value_label

    # --- field sheet -------------------------------------------------------------------------
    def _save(self) -> None:
        if self.plan is None:
            return
        formats = {"pdf": "PDF", "svg": "SVG", "html": "HTML"}
        title, name = tr("Save field sheet"), "field_sheet.pdf"
        path = ask_for_target(self, self._studio, title, name, formats)
        if path is not None:
            self.save_to(path)

    def save_to(self, path: Path) -> None:
        """Write the field sheet to a file, in the format of its suffix."""
        plan, studio = self.plan, self._studio
        if plan is None:
            return
        # Runs in a thread, because importing matplotlib takes a second.
        self._background.run(
            lambda: write_field_sheet(path, plan, force=True),
            lambda _: studio.written(path),
            studio.fail,
        )

    def _print(self) -> None:
        from PySide6.QtPrintSupport import QPrintDialog, QPrinter

        if self.plan is None:
            return
        printer = QPrinter(QPrinter.PrinterMode.HighResolution)
        if QPrintDialog(printer, self).exec() == QDialog.DialogCode.Accepted:
            self.print_to(printer)

    def print_to(self, printer: Any) -> None:
        """Print the field sheet on one page of a QPrinter."""
        from io import BytesIO

        from vomstudio.products.report.field_sheet import draw_field_sheet

        if self.plan is None:
            return
        picture = BytesIO()
        draw_field_sheet(self.plan).savefig(picture, format="png", dpi=_PRINT_DPI)
        image = QImage.fromData(picture.getvalue())
        painter = QPainter(printer)
        page = painter.viewport()
        size = image.size().scaled(page.size(), Qt.AspectRatioMode.KeepAspectRatio)
        painter.setViewport(page.x(), page.y(), size.width(), size.height())
        painter.setWindow(image.rect())
        painter.drawImage(0, 0, image)
        painter.end()

    def done(self, result: int) -> None:
        try:
            self._background.stop()
        finally:
            super().done(result)


def _camera_matches(text: str) -> list[Match]:
    """Return the lines and names of the cameras in the table that match a text."""
    return [
        (
            model.common_label
            if len(model.names) == 1
            else f"{model.common_label}  ({', '.join(model.names[:-1])})",
            model.common_label,
        )
        for model in search_cameras(text)
    ]


def _create_row(*widgets: tuple[QWidget, int]) -> QHBoxLayout:
    row = QHBoxLayout()
    for widget, stretch in widgets:
        row.addWidget(widget, stretch)
    if not any(stretch for _, stretch in widgets):
        row.addStretch(1)
    return row


def _compute_plan(values: dict[str, Any]) -> SurveyPlan:
    """Compute the plan from the texts of the fields.

    Raises
    ------
    VomError
        If an input is missing or invalid.
    """
    if not values["camera"]:
        raise InputError(Finding("plan.no-camera"))
    target = next(row for row in _TARGETS if row[1] == values["wish"])
    numbers: dict[str, float | None] = {}
    for name in ("focal", "aperture", "width", "height", "value", "receiver", "control"):
        numbers[name] = parse_number(values[name]) if values[name] else None
        if numbers[name] is None and (values[name] or name not in _OPTIONAL):
            field = tr(target[0] if name == "value" else _FIELDS[f"--{name}"])
            raise InputError(Finding("number.invalid", text=values[name]), field=field)
    target_value = {target[1]: (numbers["value"] or 0.0) / target[3]}
    try:
        camera = camera_of(values["camera"], numbers["focal"])
        options = PlanOptions(
            width_m=numbers["width"] or 0.0,
            height_m=numbers["height"] or 0.0,
            overlap=values["overlap"] / 100.0,
            manner=values["manner"],
            # The field applies to other cameras if this one has no diaphragm.
            aperture=(numbers["aperture"] or 0.0) if camera.f_number is None else None,
            receiver_m=numbers["receiver"],
            control_m=numbers["control"],
            **target_value,
        )
        return add_forecasts(plan_survey(camera, options), options.receiver_m, options.control_m)
    except VomError as error:
        name = _FIELDS.get(error.field or "", "")
        raise InputError(cause_of(error), field=tr(name) if name else None) from error
