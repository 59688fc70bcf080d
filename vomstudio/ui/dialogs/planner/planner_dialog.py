"""Dialog of the survey planner, for plans of `photogrammetry.survey.planning`."""

from __future__ import annotations

from dataclasses import asdict, replace
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
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.errors import InputError, UsageError, VomError
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.words import tr
from vomstudio.io.photos.camera_table import find_camera, search_cameras
from vomstudio.photogrammetry.survey.plan_camera import parse_camera
from vomstudio.photogrammetry.survey.plan_forecast import add_forecasts
from vomstudio.photogrammetry.survey.planning import SurveyPlan, plan_survey
from vomstudio.photogrammetry.survey.survey_options import (
    DEFAULT_APERTURE,
    DEFAULT_CONTROL_M,
    DEFAULT_RECEIVER_M,
    PlanOptions,
)
from vomstudio.products.report.field_sheet import figures, write_field_sheet
from vomstudio.ui.base import file_filters
from vomstudio.ui.base.command_targets import ask_for_target, start_folder
from vomstudio.ui.base.controls import ComboBox, Label, set_enabled
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.qt_background import LatestRequestRunner, QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.texts import format_sentence
from vomstudio.ui.dialogs.planner.plan_drawing import PlanDrawing
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey
from vomstudio.ui.widgets.options_form import OptionFields
from vomstudio.ui.widgets.search_field import Match, SearchField

_VIEW_KEY = "survey_plan"
_TYPING_DELAY_MS = 200
_TARGET_DEFAULTS = {"distance_m": 30.0, "gsd_m": 0.01, "plane_m": 5.0}
"""Default value of each option that can be the target; only one is used at a time."""
_PRINT_DPI = 300


class PlannerDialog(QDialog):
    """Dialog that updates a survey plan as the user types; the project stores the input."""

    def __init__(self, parent: QWidget, studio: Studio, survey: PhotoSurvey) -> None:
        super().__init__(parent)
        set_help_topic(self, "photos.md#planning-a-survey")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Plan photo survey"))
        self.resize(1120, 720)
        self._studio, self._survey = studio, survey
        self._background = QtBackground(self)
        self._requests = LatestRequestRunner(self, self._show_plan, self._show_error, lambda: None)
        self.plan: SurveyPlan | None = None
        stored_view = studio.project.journal.view(_VIEW_KEY, {})
        self._compute_timer = QTimer(self, singleShot=True, interval=_TYPING_DELAY_MS)
        self._compute_timer.timeout.connect(self._compute)
        self.drawing = PlanDrawing()
        initial_options = _stored_options(stored_view)
        self.options = OptionFields(PlanOptions, "plan", initial_options, is_live=True)
        self.options.changed.connect(self._schedule_plan)
        left_column = QWidget()
        left_column.setFixedWidth(430)
        column = QVBoxLayout(left_column)
        column.setContentsMargins(0, 0, 0, 0)
        column.addLayout(self._make_form(str(stored_view.get("camera", "")), initial_options))
        column.addWidget(self._make_results(), 1)
        columns = QHBoxLayout()
        columns.addWidget(left_column)
        columns.addWidget(self.drawing, 1)
        layout = QVBoxLayout(self)
        layout.addLayout(columns, 1)
        layout.addWidget(self._make_buttons())
        self._compute()

    # --- widgets -----------------------------------------------------------------------------
    def _make_form(self, camera: str, initial_options: PlanOptions) -> QFormLayout:
        self.camera = SearchField(_camera_matches)
        self.camera.setObjectName("plan_camera")
        self.camera.setPlaceholderText(tr("Name, or 23.5x15.6,35,6000x4000"))
        self.camera.setToolTip(tr("Choose a camera, or enter sensor, focal length and image size."))
        self.camera.setText(camera)
        self.camera.textChanged.connect(self._schedule_plan)
        self.camera.textChanged.connect(self._propose_manner)
        photo_button = QPushButton(tr("From a photo…"))
        # Enter in a field must not open the file dialog.
        photo_button.setAutoDefault(False)
        photo_button.setToolTip(tr("Read camera and focal length from a photo."))
        photo_button.clicked.connect(self._browse_photo)
        self.target = ComboBox()
        self.target.setObjectName("plan_target")
        target_row = QHBoxLayout()
        target_row.addWidget(self.target)
        for name in _TARGET_DEFAULTS:
            field = self.options.place(name)
            self.target.addItem(field.accessibleName(), name)
            target_row.addWidget(field, 1)
            if getattr(initial_options, name) is not None:
                self.target.setCurrentIndex(self.target.count() - 1)
        self._show_target()
        self.target.currentIndexChanged.connect(self._convert_target)
        self.options.show_automatic("receiver_m", DEFAULT_RECEIVER_M)
        self.options.show_automatic("control_m", DEFAULT_CONTROL_M)
        self.options.show_automatic("aperture", DEFAULT_APERTURE)
        camera_row = QHBoxLayout()
        camera_row.addWidget(self.camera, 1)
        camera_row.addWidget(photo_button)
        form = QFormLayout()
        form.setVerticalSpacing(6)
        form.addRow(tr("Camera"), camera_row)
        form.addRow(*self.options.place_row("focal_mm", "aperture"))
        form.addRow(*self.options.place_row("width_m", "height_m"))
        form.addRow(tr("Target"), target_row)
        self.options.add_rows(form)
        return form

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
    def _propose_manner(self, text: str) -> None:
        """Propose a drone survey for a drone camera, and a handheld survey for other cameras."""
        model = find_camera(text.strip())
        manner = self.options.options().manner
        if model is not None and model.is_drone != (manner != "handheld"):
            self.options.show_value("manner", "drone" if model.is_drone else "handheld")

    def _convert_target(self) -> None:
        """Convert the target to the newly selected quantity, for the same plan."""
        name = self.target.currentData()
        value = _TARGET_DEFAULTS[name]
        if self.plan is not None:
            value = {
                "distance_m": self.plan.distance_m,
                "gsd_m": self.plan.gsd_m,
                "plane_m": self.plan.smallest_plane_m,
            }[name]
        self.options.show_value(name, value)
        self._show_target()
        self._schedule_plan()

    def _show_target(self) -> None:
        for name in _TARGET_DEFAULTS:
            self.options.fields[name].setVisible(name == self.target.currentData())

    def _plan_options(self) -> PlanOptions:
        """Return the options of the plan, with one target. Raises InputError or UsageError."""
        target = self.target.currentData()
        options = self.options.options(
            **{name: None for name in _TARGET_DEFAULTS if name != target}
        )
        if getattr(options, target) is None:
            raise InputError(Finding("number.not-positive", value=0.0))
        return options

    def _browse_photo(self) -> None:
        start_path = str(self._survey.folder or start_folder(self._studio))
        name, _ = QFileDialog.getOpenFileName(
            self,
            tr("Choose a photo taken with this camera"),
            start_path,
            file_filters.photos(),
        )
        if name:
            self.options.show_value("focal_mm", None)
            self.camera.setText(name)

    def _schedule_plan(self, *_: object) -> None:
        self._compute_timer.start()

    # --- results -----------------------------------------------------------------------------
    def _compute(self) -> None:
        try:
            camera, options = self.camera.text().strip(), self._plan_options()
            self._requests.request(partial(_compute_plan, camera, options))
        except VomError as error:
            self._requests.cancel()
            self._show_error(error)

    def _show_error(self, error: VomError) -> None:
        self._show_plan(None, error)

    def _show_plan(self, plan: SurveyPlan | None, error: VomError | None = None) -> None:
        self.plan = plan
        self.problem.setVisible(self.plan is None)
        self.problem.setText("" if error is None else error.message)
        if self.plan is not None:
            view = {"camera": self.camera.text().strip(), "options": asdict(self._plan_options())}
            self._studio.project.journal.set_view(_VIEW_KEY, view)
        self._show_figures([] if self.plan is None else figures(self.plan))
        warnings = () if self.plan is None else self.plan.warnings
        self.warnings.setText("\n".join(f"⚠ {format_sentence(str(text))}" for text in warnings))
        has_fixed_aperture = self.plan is not None and self.plan.camera.f_number is not None
        aperture = self.options.fields["aperture"]
        set_enabled(aperture, Finding("action.aperture-fixed") if has_fixed_aperture else None)
        self.drawing.show_plan(self.plan)
        for button in (self.save_button, self.print_button):
            set_enabled(button, None if error is None else cause_finding(error))

    def _show_figures(self, rows: list[tuple[str, str]]) -> None:
        if self.plan is not None:
            count, size = len(self.plan.control_points), 100 * self.plan.target_size_m
            check_count = sum(point.use == "check" for point in self.plan.control_points)
            # The form above shows these already.
            rows = [row for row in rows if row[0] not in (tr("Outcrop"), tr("Overlap"))]
            control_text = tr(
                "{count} (check points: {checks}); targets of {size:.2g} cm",
                count=count,
                checks=check_count,
                size=size,
            )
            rows = [*rows, (tr("Control points"), control_text)]
        for name, label in self.figures.items():
            label.setVisible(name in dict(rows))
        while (item := self._grid.takeAt(0)) is not None:
            if (widget := item.widget()) is not None:
                widget.deleteLater()
        self.figures = {}
        for grid_row, (name, value) in enumerate(rows):
            value_label = Label(value)
            value_label.setWordWrap(True)
            value_label.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
            self._grid.addWidget(Label(name), grid_row, 0, Qt.AlignmentFlag.AlignTop)
            self._grid.addWidget(value_label, grid_row, 1)
            self.figures[name] = value_label

    # --- field sheet -------------------------------------------------------------------------
    def _save(self) -> None:
        if self.plan is None:
            return
        formats = {"pdf": "PDF", "svg": "SVG", "html": "HTML"}
        title, name = tr("Save field sheet"), "field_sheet.pdf"
        path = ask_for_target(self, self._studio, title, name, formats)
        if path is not None:
            self.save_field_sheet(path)

    def save_field_sheet(self, path: Path) -> None:
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
            self.print_field_sheet(printer)

    def print_field_sheet(self, printer: Any) -> None:
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
            self._requests.close()
            self._background.stop()
        finally:
            super().done(result)


def _camera_matches(text: str) -> list[Match]:
    """Return the list entry and the name of each camera in the table that matches a text."""
    return [
        (
            model.common_label
            if len(model.names) == 1
            else f"{model.common_label}  ({', '.join(model.names[:-1])})",
            model.common_label,
        )
        for model in search_cameras(text)
    ]


def _stored_options(stored_view: Any) -> PlanOptions:
    """Return the options stored with the project, or the defaults of the dialog."""
    try:
        return PlanOptions(**stored_view["options"])
    except (KeyError, TypeError, UsageError):
        return PlanOptions(width_m=80.0, height_m=25.0, distance_m=_TARGET_DEFAULTS["distance_m"])


def _compute_plan(camera_text: str, options: PlanOptions) -> SurveyPlan:
    """Compute a plan. Raises InputError or UsageError if the camera or the target is invalid."""
    if not camera_text:
        raise InputError(Finding("plan.no-camera"))
    camera = parse_camera(camera_text, options.focal_mm)
    if camera.f_number is not None:
        # The field applies to other cameras if this one has no diaphragm.
        options = replace(options, aperture=None)
    return add_forecasts(plan_survey(camera, options), options.receiver_m, options.control_m)
