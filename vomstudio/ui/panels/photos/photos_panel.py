"""Photos panel: photos in a folder, survey check and reconstruction."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, QSize, Qt, Signal
from PySide6.QtGui import QAction, QIcon, QKeySequence, QShortcut
from PySide6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QHeaderView,
    QListWidget,
    QListWidgetItem,
    QMenu,
    QSplitter,
    QStackedWidget,
    QTableWidget,
    QTableWidgetItem,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.findings import Finding
from vomstudio.core.options import find_declaration
from vomstudio.core.words import to_translate, tr, tr_n
from vomstudio.geometry.units import length_text
from vomstudio.studio.jobs.reconstruct_options import ReconstructOptions
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import (
    ComboBox,
    ElidedLabel,
    Label,
    SteadyToolButton,
    escape_markup,
    set_enabled,
)
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.texts import format_sentence
from vomstudio.ui.panels.photos import reconstruction_folders
from vomstudio.ui.panels.photos.photo_row import PhotoRow
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey
from vomstudio.ui.panels.photos.plan_view import PlanView
from vomstudio.ui.widgets.collapsing_texts import CollapsingTexts
from vomstudio.ui.widgets.options_form import fill_choices

_MIN_WIDTH_PX = 360
_THUMBNAIL_SIZE = QSize(72, 48)
_COLUMNS = (
    (to_translate("Photo"), ""),
    (to_translate("GSD"), to_translate("Ground sampling distance: size of a pixel on the rock.")),
    (
        to_translate("Blur"),
        to_translate("Blur of the sharpest edges (1σ) in pixels; smaller is sharper."),
    ),
    (
        to_translate("Mask"),
        to_translate("Part of the photo is masked. Open the photo to edit it."),
    ),
    (to_translate("Finding"), ""),
    (to_translate("Camera"), ""),
    (to_translate("Focal length"), ""),
    (to_translate("Size"), to_translate("Width × height in pixels.")),
    (to_translate("GPS"), to_translate("The photo contains its GPS position.")),
)
"""Titles and tooltips of the columns."""
_GSD_COLUMN, _MASK_COLUMN, _FINDING_COLUMN = 1, 3, 4
_MODEL_TEXTS = (to_translate("&Reconstruct"), to_translate("&Continue reconstruction"))
"""Texts of the button that makes a model, first if no reconstruction has been started."""
# Commands that show the results of the alignment.
_RESULT_ACTIONS = ("show_alignment", "show_tie_points", "open_report")
_SEVERITIES = {
    "info": "information-outline",
    "warning": "alert-outline",
    "error": "alert-octagon-outline",
}


class PhotosPanel(QWidget):
    """Panel with the photos of a folder, the survey findings and the reconstruction.

    Parameters
    ----------
    survey : PhotoSurvey
    actions : dict
        Commands of `survey_commands` by name.

    Attributes
    ----------
    selection_changed : Signal
        Emitted with the set of names of the selected photos.
    opened : Signal
        Emitted with the name of a photo that is to be opened.
    """

    selection_changed = Signal(object)
    opened = Signal(str)

    def __init__(self, survey: PhotoSurvey, actions: dict[str, QAction]) -> None:
        super().__init__()
        set_help_topic(self, "photos.md#the-survey-check")
        self._survey, self._actions = survey, actions
        self.quality = ComboBox()
        self.quality.setObjectName("quality")
        fill_choices(self.quality, find_declaration(ReconstructOptions, "quality"))
        self.quality.setCurrentIndex(self.quality.findData(survey.quality))
        self.quality.currentIndexChanged.connect(
            lambda _: survey.set_quality(self.quality.currentData())
        )
        self._verdict = ElidedLabel()
        self._verdict.setObjectName("survey_verdict")
        self.results = QToolButton()
        self.results.setObjectName("results")
        self.results.setText(tr("Results"))
        self.results.setIcon(theme.icon("file-document-outline"))
        self.results.setToolTip(tr("Show alignment, tie points and report of the reconstruction."))
        self.results.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self.results.setPopupMode(QToolButton.ToolButtonPopupMode.InstantPopup)
        menu = QMenu(self.results)
        menu.setToolTipsVisible(True)
        for name in _RESULT_ACTIONS:
            menu.addAction(actions[name])
        self.results.setMenu(menu)
        self.table = self._make_table()
        self._findings = QListWidget()
        self._failure_text = self._listed_verdict = ""
        self._placements: list[Finding] = []
        self._scale: float | None = None
        self._findings.setObjectName("findings")
        self._findings.setWordWrap(True)
        self._findings.itemSelectionChanged.connect(self._select_photos_of_finding)
        self._plan = PlanView(self.select_photo)
        splitter = QSplitter(Qt.Orientation.Horizontal)
        for widget, stretch in ((self.table, 5), (self._findings, 4), (self._plan, 3)):
            splitter.addWidget(widget)
            splitter.setStretchFactor(splitter.count() - 1, stretch)
        splitter.setChildrenCollapsible(False)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(4, 4, 4, 4)
        layout.setSpacing(4)
        layout.addWidget(self._make_header())
        self._pages = QStackedWidget()
        self._pages.addWidget(self._make_empty_page())
        self._pages.addWidget(splitter)
        layout.addWidget(self._pages, 1)
        survey.rows_changed.connect(self._fill)
        survey.changed.connect(self._refresh)
        survey.masks_changed.connect(self._show_masks)
        self._fill()

    def _make_empty_page(self) -> QWidget:
        page = QWidget()
        column = QVBoxLayout(page)
        label = Label(tr("Choose a folder of overlapping photos, or drop it here."))
        label.setAlignment(Qt.AlignmentFlag.AlignCenter)
        row = QHBoxLayout()
        row.addStretch(1)
        for name in ("choose_photos", "video_frames", "plan_survey"):
            row.addWidget(self._button(name))
        row.addStretch(1)
        column.addStretch(1)
        column.addWidget(label)
        column.addLayout(row)
        column.addStretch(1)
        return page

    def _button(self, name: str) -> QToolButton:
        # The buttons after it would move whenever its text changes.
        button = SteadyToolButton(_MODEL_TEXTS) if name == "make_model" else QToolButton()
        button.setDefaultAction(self._actions[name])
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        return button

    def _make_header(self) -> QWidget:
        row = QWidget()
        row.setMinimumWidth(_MIN_WIDTH_PX)
        header = QHBoxLayout(row)
        header.setContentsMargins(0, 0, 0, 0)
        buttons = {}
        # One word is sufficient beside the list of photos.
        self._actions["open_photo"].setIconText(tr("Open"))
        for name in ("choose_photos", "open_photo", "make_settings", "make_model", "pause_model"):
            buttons[name] = button = self._button(name)
            if name == "make_settings":
                # The buttons beside it already state its purpose.
                button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonIconOnly)
            header.addWidget(button)
            if name == "open_photo":
                header.addSpacing(8)
                header.addWidget(Label(tr("Quality")))
                header.addWidget(self.quality)
        header.addWidget(self.results)
        header.addSpacing(8)
        header.addWidget(self._verdict, 1)
        self._texts = CollapsingTexts(row, lambda: header.minimumSize().width())
        # The texts of the most frequent actions are the last to be dropped.
        self._texts.add_group([buttons["choose_photos"], self.results])
        self._texts.add_group([buttons["open_photo"], buttons["pause_model"]])
        self._texts.add_group([buttons["make_model"]])
        return row

    def _make_table(self) -> QTableWidget:
        table = QTableWidget(0, len(_COLUMNS))
        table.setObjectName("photo_table")
        table.setIconSize(_THUMBNAIL_SIZE)
        table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        table.verticalHeader().hide()
        table.horizontalHeader().setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        table.horizontalHeader().setStretchLastSection(True)
        table.itemSelectionChanged.connect(self._show_selection)
        table.doubleClicked.connect(self._open)
        for code in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            key = QShortcut(QKeySequence(code), table)
            key.setContext(Qt.ShortcutContext.WidgetShortcut)
            key.activated.connect(self._open)
        for column, (title, tooltip) in enumerate(_COLUMNS):
            header = QTableWidgetItem(tr(title))
            # `tr` of an empty text would return the header of the catalogue.
            header.setToolTip(tr(tooltip) if tooltip else "")
            table.setHorizontalHeaderItem(column, header)
        return table

    # --- rows --------------------------------------------------------------------------------
    def _fill(self) -> None:
        survey, table = self._survey, self.table
        self._scale = survey.metres_per_unit()
        with QSignalBlocker(table):
            table.setRowCount(len(survey.rows))
            for number, row in enumerate(survey.rows):
                self._fill_row(number, row)
        self._findings.clear()
        self._failure_text, self._placements = "", []
        self._listed_verdict = ""
        for finding in survey.findings:
            self._add_finding(finding.severity, finding.message, list(finding.values["photos"]))
        for finding in (*survey.control_findings(), *survey.exclusions):
            self._add_finding(finding.severity, finding.message, [])
        self._show_selection()
        self._refresh()

    def _fill_row(self, number: int, row: PhotoRow) -> None:
        cells = (
            row.name.rpartition("/")[2],
            _gsd_text(row, self._scale),
            "–" if row.blur is None else f"{row.blur:.1f} px",
            _mask_text(row),
            _truncate(row.findings[0]) if row.findings else "",
            row.camera,
            row.focal,
            f"{row.width} × {row.height}",
            tr("yes") if row.has_gps else "–",
        )
        for column, text in enumerate(cells):
            item = QTableWidgetItem(text)
            if column == 0:
                item.setToolTip(escape_markup(row.path))
                if row.thumbnail:
                    item.setIcon(theme.picture_icon(row.thumbnail, _THUMBNAIL_SIZE))
            elif column == _FINDING_COLUMN:
                item.setToolTip(escape_markup("\n".join(row.findings)))
            self.table.setItem(number, column, item)
        self.table.setRowHeight(number, _THUMBNAIL_SIZE.height() + 4)

    def _show_masks(self) -> None:
        for number, row in enumerate(self._survey.rows):
            if (item := self.table.item(number, _MASK_COLUMN)) is not None:
                item.setText(_mask_text(row))

    def _add_finding(
        self, severity: str, text: str, photos: list[str], row: int | None = None
    ) -> None:
        item = QListWidgetItem(theme.icon(_SEVERITIES[severity]), text)
        item.setData(Qt.ItemDataRole.UserRole, photos)
        self._findings.insertItem(self._findings.count() if row is None else row, item)

    def _refresh(self) -> None:
        survey = self._survey
        job = survey.reconstruction_job
        self._pages.setCurrentIndex(0 if survey.folder is None else 1)
        with QSignalBlocker(self.quality):
            self.quality.setCurrentIndex(self.quality.findData(survey.quality))
        set_enabled(self.quality, None if job is None else Finding("action.reconstruction-running"))
        self._texts.refit()
        self._verdict.setText(self._summary_text())
        self._show_failure()
        self._show_placements()
        self._show_verdict()
        action = self._actions["make_model"]
        action.setText(tr(_MODEL_TEXTS[survey.is_begun and job is None]))

    def _summary_text(self) -> str:
        survey = self._survey
        if survey.folder is None:
            return ""
        if survey.problem:
            return survey.problem
        if survey.is_listing:
            return tr("Reading the photos…")
        photos = tr_n("{count} photo", "{count} photos", len(survey.rows))
        if survey.is_reading:
            warnings = tr("being checked")
        else:
            findings = (
                *survey.findings,
                *survey.control_findings(),
                *survey.exclusions,
                *survey.placement_findings(),
            )
            count = sum(finding.severity != "info" for finding in findings)
            warnings = tr_n("{count} warning", "{count} warnings", count)
        if survey.reconstruction_job is not None:
            return tr("Reconstructing {photos}, {warnings}", photos=photos, warnings=warnings)
        if self._read_failure():
            return tr(
                "Reconstruction failed, {photos}, {warnings}", photos=photos, warnings=warnings
            )
        if survey.is_begun:
            return tr(
                "Reconstruction paused, {photos}, {warnings}", photos=photos, warnings=warnings
            )
        return tr("{photos}, {warnings}", photos=photos, warnings=warnings)

    def _read_failure(self) -> str:
        """Return why the previous run failed; empty if it was paused or did not fail."""
        out = self._survey.output_folder() if self._survey.reconstruction_job is None else None
        return "" if out is None else format_sentence(reconstruction_folders.read_failure(out))

    def _show_failure(self) -> None:
        """Show the failure of the previous run above the findings."""
        reason = self._read_failure()
        if reason == self._failure_text:
            return
        if self._failure_text:
            self._findings.takeItem(0)
        self._failure_text = reason
        if reason:
            text = tr("The reconstruction failed: {reason}", reason=reason)
            self._add_finding("error", text, [], row=0)

    def _show_verdict(self) -> None:
        """Show the verdict on the photos above their findings.

        It is omitted if the model made of them has a warning, because it is no longer a forecast.
        """
        has_warning = any(finding.severity != "info" for finding in self._placements)
        verdict = "" if has_warning else self._survey.verdict
        if verdict == self._listed_verdict:
            return
        row = 1 if self._failure_text else 0
        if self._listed_verdict:
            self._findings.takeItem(row)
        self._listed_verdict = verdict
        if verdict:
            self._add_finding("info", verdict, [], row=row)
            item = self._findings.item(row)
            font = item.font()
            font.setBold(True)
            item.setFont(font)
            item.setIcon(QIcon())

    def _show_placements(self) -> None:
        """Show the placement of the models of these photos as the last findings."""
        placements = self._survey.placement_findings()
        if placements != self._placements:
            for _ in self._placements:
                self._findings.takeItem(self._findings.count() - 1)
            self._placements = placements
            for finding in placements:
                self._add_finding(finding.severity, finding.message, [])
        if (scale := self._survey.metres_per_unit()) != self._scale:
            self._scale = scale
            for number, row in enumerate(self._survey.rows):
                if (item := self.table.item(number, _GSD_COLUMN)) is not None:
                    item.setText(_gsd_text(row, scale))

    # --- selection ---------------------------------------------------------------------------
    def _selected_names(self) -> set[str]:
        rows = {index.row() for index in self.table.selectionModel().selectedRows()}
        return {self._survey.rows[row].name for row in rows if row < len(self._survey.rows)}

    def selected_photo(self) -> str | None:
        """Return the name of the first selected photo, or None if none is selected."""
        names = self._selected_names()
        return next((row.name for row in self._survey.rows if row.name in names), None)

    def _open(self) -> None:
        row = self.table.currentRow()
        if 0 <= row < len(self._survey.rows):
            self.opened.emit(self._survey.rows[row].name)

    def _show_selection(self) -> None:
        survey = self._survey
        names = self._selected_names()
        self._plan.show_rows(survey.rows, names, survey.frame)
        self.selection_changed.emit(names)

    def select_photo(self, name: str) -> None:
        """Select the photo with this name and scroll to it."""
        for number, row in enumerate(self._survey.rows):
            if row.name == name:
                self.table.selectRow(number)
                self.table.scrollTo(self.table.model().index(number, 0))

    def _select_photos_of_finding(self) -> None:
        """Select the photos to which the selected findings apply."""
        names: set[str] = set()
        for item in self._findings.selectedItems():
            names.update(item.data(Qt.ItemDataRole.UserRole) or ())
        self.table.clearSelection()
        mode = QAbstractItemView.SelectionMode
        self.table.setSelectionMode(mode.MultiSelection)
        for number, row in enumerate(self._survey.rows):
            if row.name in names:
                self.table.selectRow(number)
        self.table.setSelectionMode(mode.ExtendedSelection)


def _mask_text(row: PhotoRow) -> str:
    return "–" if row.mask is None else tr("yes")


def _truncate(text: str) -> str:
    """Return the beginning of a finding; the list and the tooltip contain the full text."""
    return text if len(text) <= 48 else text[:46].rstrip() + " …"


def _gsd_text(row: PhotoRow, metres_per_unit: float | None) -> str:
    gsd_m = row.gsd_m
    if gsd_m is None and row.gsd is not None and metres_per_unit is not None:
        gsd_m = row.gsd * metres_per_unit
    if gsd_m is None:
        return length_text(row.gsd, 2, is_metric=False)
    gsd_mm = round(1000.0 * gsd_m, 1)
    return f"{gsd_mm:.1f} mm" if gsd_mm < 10.0 else f"{gsd_m * 100:.1f} cm"
