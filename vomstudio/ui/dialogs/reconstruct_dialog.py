"""The reconstruction settings: quality, registration, and the resources of this computer."""

from __future__ import annotations

import html
from collections.abc import Sequence
from dataclasses import replace
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
    QRadioButton,
    QSpinBox,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, cause_of
from vomstudio.core.words import tr, tr_n
from vomstudio.io.gis.crs import parse_crs
from vomstudio.photogrammetry.pipeline.memory_estimate import MemoryNeed
from vomstudio.studio.jobs.reconstruct_options import ReconstructOptions
from vomstudio.studio.jobs.survey_tasks import ControlFacts, PointFacts
from vomstudio.ui.base import file_filters, theme
from vomstudio.ui.base.controls import (
    ComboBox,
    Label,
    allow,
    file_field,
    rich_label,
    rich_lines,
)
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.number_formatting import gigabytes
from vomstudio.ui.base.texts import format_sentence
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey
from vomstudio.ui.panels.photos.reconstruction_settings import QUALITIES, ReconstructionSettings
from vomstudio.ui.widgets.crs_field import CrsField
from vomstudio.ui.widgets.options_form import OptionFields

_TYPING_MS = 400
_ROWS = 8


class ReconstructDialog(QDialog):
    """Every choice takes effect at once, and closing the dialog keeps it. make : the action that
    starts the reconstruction, whose text is on the button"""

    def __init__(self, parent: QWidget, survey: PhotoSurvey, make: QAction) -> None:
        super().__init__(parent)
        explain(self, "photos.md")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Reconstruction settings"))
        self.setMinimumWidth(720)
        self._survey, self._make_model = survey, make
        self._filling = False
        self._known = self._survey.settings
        """As they were last filled in or chosen here."""
        self._soon = QTimer(self)
        self._soon.setSingleShot(True)
        self._soon.setInterval(_TYPING_MS)
        self._soon.timeout.connect(self._choose)
        layout = QVBoxLayout(self)
        layout.addLayout(self._make_photos())
        layout.addWidget(self._make_place())
        layout.addWidget(self._make_machine())
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        self.start = buttons.addButton(
            make.text().replace("&", ""), QDialogButtonBox.ButtonRole.AcceptRole
        )
        self.start.setIcon(make.icon())
        self.start.clicked.connect(self._make)
        buttons.rejected.connect(self.close)
        layout.addWidget(buttons)
        self._fill()
        self._survey.changed.connect(self._survey_changed)
        self._show_forecast()
        # Marks may have been placed since the photos were opened.
        self._survey.update_forecast()

    # --- parts -------------------------------------------------------------------------------
    def _make_photos(self) -> QFormLayout:
        survey = self._survey
        form = QFormLayout()
        name = "" if survey.folder is None else survey.folder.name
        photos = tr_n(
            "<b>{folder}</b>, {count} photo",
            "<b>{folder}</b>, {count} photos",
            len(survey.rows),
            folder=html.escape(name),
        )
        form.addRow(tr("Photos"), rich_label(photos))
        self.quality = ComboBox()
        self.quality.setObjectName("make_quality")
        for title, key, tip in QUALITIES:
            self.quality.addItem(f"{tr(title)}: {tr(tip)}", key)
        self.quality.currentIndexChanged.connect(self._choose)
        form.addRow(tr("Quality"), self.quality)
        return form

    def _make_place(self) -> QGroupBox:
        box = QGroupBox(tr("Registration: position, scale and orientation"))
        self.by_gps = QRadioButton(tr("GPS positions of the photos (without them: a local frame)"))
        self.by_control = QRadioButton(tr("Ground control points"))
        self.control, control_row = file_field("control_file", tr("Choose…"), self._browse_control)
        self.control.setPlaceholderText(
            tr("Table with label, x, y, z, or XML file of MicMac or Metashape")
        )
        self.marks, marks_row = file_field("marks_file", tr("Choose…"), self._browse_marks)
        self.marks.setPlaceholderText(
            tr("If empty: marks.csv beside the control points, or in their file")
        )
        self._control_rows = (control_row, marks_row)
        for field in (self.control, self.marks):
            field.textEdited.connect(self._typing)
        self.crs = CrsField()
        self.crs.setObjectName("make_crs")
        self.crs.textEdited.connect(self._typing)
        self.crs.setMaximumWidth(170)
        self.crs.setPlaceholderText(tr("Automatic"))
        self._crs_words = Label()
        self._crs_words.setWordWrap(True)
        crs_row = QHBoxLayout()
        crs_row.addWidget(self.crs)
        crs_row.addWidget(self._crs_words, 1)
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
        self.points.setFixedHeight(height * (_ROWS + 1) + 8)
        self.verdict = rich_label()
        self.verdict.setObjectName("control_verdict")
        self.verdict.setWordWrap(True)
        self.verdict.setAlignment(Qt.AlignmentFlag.AlignTop)
        said = QHBoxLayout()
        said.addWidget(self.points)
        said.addWidget(self.verdict, 1)
        self._facts = QWidget()
        self._facts.setLayout(said)
        said.setContentsMargins(0, 0, 0, 0)
        form = QFormLayout(box)
        form.setVerticalSpacing(6)
        form.addRow(self.by_gps)
        form.addRow(self.by_control)
        form.addRow(tr("Points"), control_row)
        form.addRow(tr("Marks"), marks_row)
        form.addRow(self._facts)
        form.addRow(tr("CRS"), crs_row)
        self.by_control.toggled.connect(self._choose)
        return box

    def _make_machine(self) -> QGroupBox:
        box = QGroupBox(tr("This computer"))
        self.machine = OptionFields(ReconstructOptions, "make")
        self.machine.changed.connect(self._typing)
        fields, labels = self.machine.fields, self.machine.labels
        for field in fields.values():
            if isinstance(field, QSpinBox):
                # The dialog itself waits for a pause in typing.
                field.setKeyboardTracking(True)
        self.memory = Label()
        self.memory.setObjectName("make_memory")
        self.memory.setWordWrap(True)
        first = QHBoxLayout()
        first.addWidget(fields["threads"])
        first.addSpacing(8)
        first.addWidget(self.memory, 1)
        second = QHBoxLayout()
        second.addWidget(fields["seed"])
        second.addSpacing(16)
        second.addWidget(labels["scheduler"])
        second.addWidget(fields["scheduler"], 1)
        form = QFormLayout(box)
        form.addRow(labels["threads"], first)
        form.addRow(labels["seed"], second)
        return box

    # --- settings ----------------------------------------------------------------------------
    def _fill(self) -> None:
        """Show the settings as they are."""
        settings = self._known = self._survey.settings
        self._filling = True
        self.quality.setCurrentIndex(self.quality.findData(settings.quality))
        self.by_control.setChecked(settings.control is not None)
        self.by_gps.setChecked(settings.control is None)
        self.control.setText("" if settings.control is None else str(settings.control))
        self.marks.setText("" if settings.marks is None else str(settings.marks))
        self.crs.setText(settings.crs or "")
        for name in self.machine.fields:
            self.machine.show_value(name, getattr(settings, name))
        self._filling = False

    def _settings(self) -> ReconstructionSettings:
        def path(field: QLineEdit) -> Path | None:
            text = field.text().strip()
            return Path(text).expanduser() if text else None

        control = path(self.control) if self.by_control.isChecked() else None
        before, machine = self._survey.settings, self.machine.options()
        marks = path(self.marks) if control is not None else None
        try:
            crs = parse_crs(self.crs.text())[0] if self.crs.text().strip() else None
        except VomError:
            crs = None
        same = (control, marks) == (before.control, before.marks)
        return replace(
            before,
            quality=str(self.quality.currentData()),
            control=control,
            marks=marks,
            # What is asked for beside them makes them asked for.
            found=before.found and same and crs is None,
            crs=crs,
            threads=machine.threads,
            seed=machine.seed,
            scheduler=machine.scheduler,
        )

    def _typing(self, *_: object) -> None:
        if not self._filling:
            self._soon.start()

    def _survey_changed(self) -> None:
        if self._survey.settings != self._known and not self._soon.isActive():
            # By the panel, or by other photos: what is shown here would undo it.
            self._fill()
        self._show_forecast()

    def _choose(self, *_: object) -> None:
        if self._filling:
            return
        self._soon.stop()
        settings = self._known = self._settings()
        if settings != self._survey.settings:
            self._survey.choose(settings)
        self._show_forecast()

    # --- what it means -----------------------------------------------------------------------
    def _show_forecast(self) -> None:
        survey = self._survey
        by_control = self.by_control.isChecked()
        for row in self._control_rows:
            allow(row, None if by_control else Finding("action.not-by-control"))
        self._facts.setVisible(by_control)
        facts = survey.control_facts if by_control else None
        self._show_points(() if facts is None else facts.points)
        self.verdict.setText(self._words(facts))
        self._crs_words.setText(self._about_crs(facts))
        memory = None if survey.forecast is None else survey.forecast.memory
        if memory is not None:
            self.memory.setText(_memory_words(memory))
        why = survey.why_not_make() or self._bad_crs() or self._no_file()
        allow(self.start, why)

    def _show_points(self, points: Sequence[PointFacts]) -> None:
        self.points.setRowCount(len(points))
        for row, point in enumerate(points):
            where = tr_n("{count} photo", "{count} photos", point.photos)
            cells = (point.label, tr(point.use), where)
            for column, text in enumerate(cells):
                item = QTableWidgetItem(text)
                if column == 2:
                    item.setIcon(theme.verdict_icon(point.quality))
                self.points.setItem(row, column, item)

    def _words(self, facts: ControlFacts | None) -> str:
        if (missing := self._no_file()) is not None:
            return missing.message
        if self._survey.forecasting:
            return tr("Checking the control points…")
        if facts is None:
            note = self._survey.control_note
            return "" if note is None else html.escape(note.message)
        first = facts.problem or facts.summary
        said = [format_sentence(str(text)) for text in (first, *facts.warnings)]
        return rich_lines(said, said[:1])

    def _no_file(self) -> Finding | None:
        if self.by_control.isChecked() and not self.control.text().strip():
            return Finding("control.no-file")
        return None

    def _bad_crs(self) -> Finding | None:
        text = self.crs.text().strip()
        if not text:
            return None
        try:
            return None if parse_crs(text)[1] == 1.0 else Finding("frame.not-in-metres", crs=text)
        except VomError as error:
            return cause_of(error)

    def _about_crs(self, facts: ControlFacts | None) -> str:
        if (bad := self._bad_crs()) is not None:
            return bad.message
        if facts is not None:
            return f"{facts.crs or ''} {facts.crs_reason or ''}".strip()
        if self.crs.text().strip():
            return ""
        return tr("If empty: the UTM zone of the GPS positions")

    # --- choosing files ----------------------------------------------------------------------
    def _browse_control(self) -> None:
        if name := self._browse(tr("Choose the control points"), self.control):
            self.control.setText(name)
            self._choose()

    def _browse_marks(self) -> None:
        if name := self._browse(tr("Choose the image marks"), self.marks):
            self.marks.setText(name)
            self._choose()

    def _browse(self, title: str, field: QLineEdit) -> str:
        start = field.text() or self.control.text() or str(self._survey.folder or "")
        return QFileDialog.getOpenFileName(self, title, start, file_filters.ground_control())[0]

    def _make(self) -> None:
        self._choose()
        if self._survey.why_not_make() is None:
            self._make_model.trigger()
            # The user may have thought better of it when asked for the project's place.
            if self._survey.making is not None:
                self.close()

    def done(self, result: int) -> None:
        try:
            if self._soon.isActive():
                self._choose()
        finally:
            super().done(result)


def _memory_words(memory: MemoryNeed) -> str:
    needed, free = gigabytes(memory.needed_bytes), gigabytes(memory.free_bytes)
    words = tr(
        "Depth maps and point cloud need up to {needed} of {free} of free memory.",
        needed=needed,
        free=free,
    )
    if memory.size_px < memory.wanted_px:
        words += " " + tr(
            "To fit into it, depth maps are made at {size} instead of {wanted} pixels.",
            size=memory.size_px,
            wanted=memory.wanted_px,
        )
    return words
