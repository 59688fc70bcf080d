"""Dialog of the reconstruction settings: quality, registration and resources."""

from __future__ import annotations

import html
from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import Qt, QTimer
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QAbstractItemView,
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFormLayout,
    QGroupBox,
    QHBoxLayout,
    QHeaderView,
    QLineEdit,
    QPushButton,
    QRadioButton,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.errors import UsageError, VomError
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.words import tr, tr_n
from vomstudio.io.gis.crs import parse_crs
from vomstudio.photogrammetry.pipeline.memory_estimate import MemoryRequirement
from vomstudio.project.photo_edits import photo_set_name
from vomstudio.studio.jobs.reconstruct_options import ReconstructOptions
from vomstudio.studio.jobs.survey_tasks import ControlSummary, PointSummary
from vomstudio.ui.base import file_filters, theme
from vomstudio.ui.base.controls import (
    ComboBox,
    Label,
    file_field,
    rich_label,
    rich_lines,
    set_enabled,
)
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.number_formatting import gigabytes_text
from vomstudio.ui.base.qt_owner import connect_until_deleted
from vomstudio.ui.base.texts import format_sentence
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey
from vomstudio.ui.panels.photos.reconstruction_settings import ReconstructionSettings
from vomstudio.ui.panels.photos.region_choice import RegionChoice
from vomstudio.ui.widgets.crs_field import CrsField
from vomstudio.ui.widgets.options_form import OptionFields

_TYPING_DELAY_MS = 400
_VISIBLE_ROWS = 8


class ReconstructDialog(QDialog):
    """Editor of the reconstruction settings. Every change takes effect immediately.

    `reconstruct_action` starts the reconstruction and provides the text of the start button.
    """

    def __init__(
        self,
        parent: QWidget,
        survey: PhotoSurvey,
        reconstruct_action: QAction,
        region_choice: RegionChoice,
    ) -> None:
        super().__init__(parent)
        set_help_topic(self, "photos.md")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Reconstruction settings"))
        self.setMinimumWidth(720)
        self._survey, self._reconstruct_action = survey, reconstruct_action
        self._region_choice = region_choice
        self._is_filling = False
        self._is_following_box = False
        """Whether the region changes while the clipping box is dragged."""
        self._shown_settings = self._survey.settings
        """Settings that were last shown or changed here."""
        self._apply_timer = QTimer(self, singleShot=True, interval=_TYPING_DELAY_MS)
        self._apply_timer.timeout.connect(self._apply)
        self.options = OptionFields(ReconstructOptions, "make", is_live=True)
        self.options.changed.connect(self._schedule_apply)
        layout = QVBoxLayout(self)
        layout.addLayout(self._make_photos())
        layout.addWidget(self._make_extent())
        layout.addWidget(self._make_registration())
        layout.addWidget(self._make_resources())
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        self.start_button = buttons.addButton(
            reconstruct_action.text().replace("&", ""), QDialogButtonBox.ButtonRole.AcceptRole
        )
        self.start_button.setIcon(reconstruct_action.icon())
        self.start_button.clicked.connect(self._reconstruct)
        buttons.rejected.connect(self.close)
        layout.addWidget(buttons)
        self._fill()
        self._survey.changed.connect(self._update_from_survey)
        connect_until_deleted(self, region_choice.display_changed, self._follow_clipping_box)
        self._show_forecast()
        # Marks may have changed since the photos were opened.
        self._survey.update_forecast()

    # --- widgets -----------------------------------------------------------------------------
    def _make_photos(self) -> QFormLayout:
        survey = self._survey
        form = QFormLayout()
        name = "" if survey.folder is None else photo_set_name(survey.folder)
        photos = tr_n(
            "<b>{folder}</b>, {count} photo",
            "<b>{folder}</b>, {count} photos",
            len(survey.rows),
            folder=html.escape(name),
        )
        form.addRow(tr("Photos"), rich_label(photos))
        label, row = self.options.place_row("quality")
        self._quality_tip = Label()
        row.addWidget(self._quality_tip, 2)
        form.addRow(label, row)
        return form

    def _make_extent(self) -> QGroupBox:
        box = QGroupBox(tr("Extent"))
        self.propose_button = QPushButton(tr("Propose"))
        self.propose_button.setToolTip(tr("Box around the tie points of the rock."))
        self.propose_button.clicked.connect(self._propose_region)
        self.clip_button = QPushButton(tr("Clipping box"))
        self.clip_button.setToolTip(tr("Use the clipping box of the outcrop."))
        self.clip_button.clicked.connect(self._use_clipping_box)
        form = QFormLayout(box)
        region_field = self.options.fields["region"]
        assert isinstance(region_field, QLineEdit)
        region_field.textEdited.connect(self._stop_following)
        label, row = self.options.place_row("region")
        row.addWidget(self.propose_button)
        row.addWidget(self.clip_button)
        form.addRow(self.options.place("keep_background"))
        form.addRow(label, row)
        return box

    def _make_registration(self) -> QGroupBox:
        box = QGroupBox(tr("Registration"))
        self.gps_button = QRadioButton()
        self.control_button = QRadioButton(tr("Ground control points"))
        self.control, control_row = file_field("control_file", tr("Choose…"), self._browse_control)
        self.control.setPlaceholderText(
            tr("Table with label, x, y, z, or XML from MicMac or Metashape")
        )
        self.marks, marks_row = file_field("marks_file", tr("Choose…"), self._browse_marks)
        self.marks.setPlaceholderText(
            tr("If empty: marks in the control point file, or marks.csv next to it")
        )
        self._control_rows = (control_row, marks_row)
        for field in (self.control, self.marks):
            field.textEdited.connect(self._schedule_apply)
        self.crs = CrsField(preferred_names=self._survey.crs_codes())
        self.crs.setObjectName("make_crs")
        self.crs.textEdited.connect(self._schedule_apply)
        self.crs.setMaximumWidth(170)
        self.crs.setPlaceholderText(tr("Automatic"))
        self._crs_message = Label()
        self._crs_message.setWordWrap(True)
        crs_row = QHBoxLayout()
        crs_row.addWidget(self.crs)
        crs_row.addWidget(self._crs_message, 1)
        self.points = QTableWidget(0, 3)
        self.points.setObjectName("control_points")
        self.points.setHorizontalHeaderLabels([tr("Point"), tr("Use"), tr("Marks")])
        self.points.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.points.setSelectionMode(QAbstractItemView.SelectionMode.NoSelection)
        self.points.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.points.verticalHeader().hide()
        header = self.points.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        header.setStretchLastSection(True)
        self.points.setFixedWidth(280)
        height = self.fontMetrics().height() + 6
        self.points.verticalHeader().setMinimumSectionSize(height)
        self.points.verticalHeader().setDefaultSectionSize(height)
        self.points.setFixedHeight(height * (_VISIBLE_ROWS + 1) + 8)
        self.verdict = rich_label()
        self.verdict.setObjectName("control_verdict")
        self.verdict.setWordWrap(True)
        self.verdict.setAlignment(Qt.AlignmentFlag.AlignTop)
        results = QHBoxLayout()
        results.addWidget(self.points)
        results.addWidget(self.verdict, 1)
        self._control_area = QWidget()
        self._control_area.setLayout(results)
        results.setContentsMargins(0, 0, 0, 0)
        form = QFormLayout(box)
        form.setVerticalSpacing(6)
        form.addRow(self.gps_button)
        form.addRow(self.control_button)
        form.addRow(tr("Points"), control_row)
        form.addRow(tr("Marks"), marks_row)
        form.addRow(self._control_area)
        form.addRow(tr("CRS"), crs_row)
        self.control_button.toggled.connect(self._apply)
        return box

    def _make_resources(self) -> QGroupBox:
        box = QGroupBox(tr("This computer"))
        self.memory = Label()
        self.memory.setObjectName("make_memory")
        self.memory.setWordWrap(True)
        form = QFormLayout(box)
        label, row = self.options.place_row("threads")
        row.addWidget(self.memory, 2)
        form.addRow(label, row)
        form.addRow(*self.options.place_row("seed", "scheduler"))
        self.options.add_rows(form)
        return box

    # --- settings ----------------------------------------------------------------------------
    def _fill(self) -> None:
        settings = self._shown_settings = self._survey.settings
        self._is_filling = True
        self.control_button.setChecked(settings.control is not None)
        self.gps_button.setChecked(settings.control is None)
        self.control.setText("" if settings.control is None else str(settings.control))
        self.marks.setText("" if settings.marks is None else str(settings.marks))
        self.crs.setText(settings.options.crs or "")
        for name in self.options.fields:
            self.options.show_value(name, getattr(settings.options, name))
        self._is_filling = False

    def _settings(self) -> ReconstructionSettings:
        def path(field: QLineEdit) -> Path | None:
            text = field.text().strip()
            return Path(text).expanduser() if text else None

        control = path(self.control) if self.control_button.isChecked() else None
        marks = path(self.marks) if control is not None else None
        previous_settings = self._survey.settings
        try:
            crs = parse_crs(self.crs.text())[0] if self.crs.text().strip() else None
        except VomError:
            crs = None
        try:
            options = self.options.options(crs=crs)
        except UsageError:
            # The region is still being typed.
            options = self.options.options(crs=crs, region=previous_settings.options.region)
        is_same_control = (control, marks) == (previous_settings.control, previous_settings.marks)
        # Other changes confirm control files that were found automatically.
        is_sidecar = previous_settings.has_sidecar_control and is_same_control and crs is None
        return ReconstructionSettings(options).replace_control(
            control, marks, is_sidecar=is_sidecar
        )

    def _schedule_apply(self, *_: object) -> None:
        if not self._is_filling:
            self._apply_timer.start()

    def _update_from_survey(self) -> None:
        if self._survey.settings != self._shown_settings and not self._apply_timer.isActive():
            # The settings were changed by the panel or for other photos; the old values would
            # revert this.
            self._fill()
        self._show_forecast()

    def _apply(self, *_: object) -> None:
        if self._is_filling:
            return
        self._apply_timer.stop()
        settings = self._shown_settings = self._settings()
        if settings != self._survey.settings:
            self._survey.apply_settings(settings)
        self._show_forecast()

    # --- forecast ----------------------------------------------------------------------------
    def _show_forecast(self) -> None:
        survey = self._survey
        quality = self.options.fields["quality"]
        assert isinstance(quality, ComboBox)
        self._quality_tip.setText(quality.currentData(Qt.ItemDataRole.ToolTipRole))
        has_gps = any(row.has_gps for row in survey.rows)
        self.gps_button.setText(
            tr("GPS positions of the photos")
            if has_gps
            else tr("None: a local frame without scale")
        )
        has_control = self.control_button.isChecked()
        for row in self._control_rows:
            set_enabled(row, None if has_control else Finding("action.not-by-control"))
        self._control_area.setVisible(has_control)
        facts = survey.control_facts if has_control else None
        self._show_points(() if facts is None else facts.points)
        self.verdict.setText(self._verdict_text(facts))
        self._crs_message.setText(self._crs_text(facts))
        memory = None if survey.forecast is None else survey.forecast.memory
        if memory is not None:
            self.memory.setText(_describe_memory(memory))
        has_region = self.options.value("region") is not None
        set_enabled(
            self.options.fields["keep_background"],
            Finding("action.region-set") if has_region else None,
        )
        set_enabled(self.propose_button, self._region_choice.proposal_problem())
        set_enabled(self.clip_button, self._region_choice.clip_box_problem())
        problem = (
            survey.reconstruction_problem()
            or self._crs_problem()
            or self._missing_file()
            or self._options_problem()
        )
        set_enabled(self.start_button, problem)

    def _show_points(self, points: Sequence[PointSummary]) -> None:
        self.points.setRowCount(len(points))
        for row, point in enumerate(points):
            photo_count = tr_n("{count} photo", "{count} photos", point.photos)
            cells = (point.label, tr(point.use), photo_count)
            for column, text in enumerate(cells):
                item = QTableWidgetItem(text)
                if column == 2:
                    item.setIcon(theme.verdict_icon(point.quality))
                self.points.setItem(row, column, item)

    def _verdict_text(self, facts: ControlSummary | None) -> str:
        if (missing_file := self._missing_file()) is not None:
            return missing_file.message
        if self._survey.is_forecasting:
            return tr("Checking the control points…")
        if facts is None:
            note = self._survey.control_finding
            return "" if note is None else html.escape(note.message)
        main_text = facts.problem or facts.summary
        sentences = [format_sentence(str(text)) for text in (main_text, *facts.warnings)]
        return rich_lines(sentences, sentences[:1])

    def _missing_file(self) -> Finding | None:
        if self.control_button.isChecked() and not self.control.text().strip():
            return Finding("control.no-file")
        return None

    def _crs_problem(self) -> Finding | None:
        text = self.crs.text().strip()
        if not text:
            return None
        try:
            return None if parse_crs(text)[1] == 1.0 else Finding("frame.not-in-metres", crs=text)
        except VomError as error:
            return cause_finding(error)

    def _options_problem(self) -> Finding | None:
        try:
            self.options.options()
        except UsageError as error:
            return cause_finding(error)
        return None

    def _crs_text(self, facts: ControlSummary | None) -> str:
        if (problem := self._crs_problem()) is not None:
            return problem.message
        if facts is not None:
            return f"{facts.crs or ''} {facts.crs_reason or ''}".strip()
        if self.crs.text().strip():
            return ""
        if not any(row.has_gps for row in self._survey.rows):
            return ""
        return tr("If empty: the UTM zone of the GPS positions")

    # --- region ------------------------------------------------------------------------------
    def _show_region(self, region: tuple[float, ...]) -> None:
        self.options.show_value("region", ",".join(f"{value:.12g}" for value in region))

    def _propose_region(self) -> None:
        """Set the proposed region, and show it in the outcrop, where its faces can be dragged."""
        if (region := self._region_choice.proposal()) is not None:
            self._region_choice.show(region)
            self._use_clipping_box()

    def _use_clipping_box(self) -> None:
        if (region := self._region_choice.clipped_region()) is not None:
            self._is_following_box = True
            self._show_region(region)
            self._apply()

    def _stop_following(self) -> None:
        self._is_following_box = False

    def _follow_clipping_box(self, subject: str) -> None:
        if subject == "clip":
            self._show_forecast()
        region = self._region_choice.clipped_region()
        if subject == "box" and self._is_following_box and region is not None:
            # The options signal the change, which is applied once the drag pauses.
            self._show_region(region)

    # --- file choice -------------------------------------------------------------------------
    def _browse_control(self) -> None:
        if name := self._browse(tr("Choose the control points"), self.control):
            self.control.setText(name)
            self._apply()

    def _browse_marks(self) -> None:
        if name := self._browse(tr("Choose the image marks"), self.marks):
            self.marks.setText(name)
            self._apply()

    def _browse(self, title: str, field: QLineEdit) -> str:
        start_path = field.text() or self.control.text() or str(self._survey.folder or "")
        return QFileDialog.getOpenFileName(self, title, start_path, file_filters.ground_control())[
            0
        ]

    def _reconstruct(self) -> None:
        self._apply()
        if self._survey.reconstruction_problem() is None:
            self._reconstruct_action.trigger()
            # The user may have cancelled the choice of a project folder.
            if self._survey.reconstruction_job is not None:
                self.close()

    def done(self, result: int) -> None:
        try:
            if self._apply_timer.isActive():
                self._apply()
        finally:
            super().done(result)


def _describe_memory(memory: MemoryRequirement) -> str:
    findings = [
        Finding(
            "reconstruction.memory",
            needed=gigabytes_text(memory.needed_bytes),
            free=gigabytes_text(memory.free_bytes),
            needed_bytes=memory.needed_bytes,
            free_bytes=memory.free_bytes,
        )
    ]
    if memory.size_px < memory.wanted_px:
        code = "reconstruction.reduced-depth-maps"
        findings.append(Finding(code, size_px=memory.size_px, wanted_px=memory.wanted_px))
    return " ".join(finding.message for finding in findings)
